"""A client of `trajopt serve`, blocking and asynchronous; it needs the extra `server` for httpx."""

from trajopt.server.client.asynchronous import AsyncClient as AsyncClient
from trajopt.server.client.asynchronous import AsyncSession as AsyncSession
from trajopt.server.client.blocking import Client as Client
from trajopt.server.client.blocking import Session as Session
from trajopt.server.client.calls import ServerError as ServerError
from trajopt.server.client.calls import trajectory_of as trajectory_of
