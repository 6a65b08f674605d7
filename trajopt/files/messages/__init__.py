"""Messages of ROS and MoveIt, each defined once, for scripts, files and the network.

The messages are data classes with ROS' defaults, such as `moveit_msgs.PlanningScene`; each module is one ROS
package. `encode` converts a message to a document in the form of ROS 1 or ROS 2, and `decode` does the
reverse for both. `document_of` prepares messages for the readers of `trajopt.files.moveit`.
"""

from trajopt.files.messages.codec import Generation as Generation
from trajopt.files.messages.codec import decode as decode
from trajopt.files.messages.codec import encode as encode
from trajopt.files.messages.documents import document_of as document_of
from trajopt.files.messages.documents import field_names as field_names
from trajopt.files.messages.documents import is_message as is_message
from trajopt.files.messages.names import message_named as message_named
from trajopt.files.messages.names import name_of as name_of
