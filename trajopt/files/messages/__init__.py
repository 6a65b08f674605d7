"""Messages of ROS and MoveIt, written once in the table of `definitions`.

Each message is a data class with ROS' defaults: `from trajopt.files.messages import PlanningScene`.
"""

from trajopt.files.messages.definitions import definitions as definitions
from trajopt.files.messages.message import PACKAGES as PACKAGES
from trajopt.files.messages.message import Generation as Generation
from trajopt.files.messages.message import class_in as class_in
from trajopt.files.messages.message import classes_of as classes_of
from trajopt.files.messages.message import decode as decode
from trajopt.files.messages.message import document_of as document_of
from trajopt.files.messages.message import encode as encode
from trajopt.files.messages.message import field_names as field_names
from trajopt.files.messages.message import import_package as import_package
from trajopt.files.messages.message import is_message as is_message
from trajopt.files.messages.message import message_named as message_named
from trajopt.files.messages.message import name_of as name_of
from trajopt.files.messages.message import plain_name as plain_name

__getattr__ = class_in()
