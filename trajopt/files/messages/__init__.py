"""Messages of ROS and MoveIt: each defined once, for scripts, files and the wire.

`moveit_msgs.PlanningScene` and the others are data classes with ROS' defaults; a package of ROS is a module
here. `encode` makes a document of a message as ROS 1 or ROS 2 writes it, `decode` a message of a document of
either; `document_of` is what MoveIt's files are read from, here and in `trajopt.files.moveit`.
"""

from trajopt.files.messages.codec import Generation as Generation
from trajopt.files.messages.codec import decode as decode
from trajopt.files.messages.codec import encode as encode
from trajopt.files.messages.documents import document_of as document_of
from trajopt.files.messages.documents import field_names as field_names
from trajopt.files.messages.documents import is_message as is_message
from trajopt.files.messages.names import message_named as message_named
from trajopt.files.messages.names import name_of as name_of
