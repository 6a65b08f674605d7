"""A client of `trajopt serve`, blocking and asynchronous; it needs the extra `server` for httpx."""

from trajopt.server.client.calls import ServerError as ServerError
from trajopt.server.client.calls import trajectory_of as trajectory_of
from trajopt.server.client.clients import AsyncClient as AsyncClient
from trajopt.server.client.clients import AsyncSession as AsyncSession
from trajopt.server.client.clients import Client as Client
from trajopt.server.client.clients import Session as Session
