"""A client of `trajopt serve`, blocking and asynchronous; it needs the extra `server` for httpx."""

from trajopt.client.answers import trajectory_of as trajectory_of
from trajopt.client.asynchronous import AsyncClient as AsyncClient
from trajopt.client.asynchronous import AsyncSession as AsyncSession
from trajopt.client.blocking import Client as Client
from trajopt.client.blocking import Session as Session
from trajopt.client.errors import ServerError as ServerError
