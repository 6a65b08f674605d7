"""The face that speaks HTTP: JSON in and out, feedback as server-sent events."""

from trajopt.server.http.answers import HttpOptions as HttpOptions
from trajopt.server.http.app import Metrics as Metrics
from trajopt.server.http.app import http_app as http_app
from trajopt.server.http.run import serve_http as serve_http
