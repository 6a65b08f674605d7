// What people write with roslibjs, against a bridge: node roslib_script.mjs PORT. Prints what it got as JSON.
import * as ROSLIB from "roslib";

const ros = new ROSLIB.Ros({ url: `ws://127.0.0.1:${process.argv[2]}` });
await new Promise((resolve, reject) => {
  ros.on("connection", resolve);
  ros.on("error", reject);
});

const call = (name, serviceType, request) =>
  new Promise((resolve, reject) =>
    new ROSLIB.Service({ ros, name, serviceType }).callService(request, resolve, reject),
  );
const once = (name, messageType) =>
  new Promise((resolve) => {
    const topic = new ROSLIB.Topic({ ros, name, messageType });
    topic.subscribe((message) => {
      topic.unsubscribe();
      resolve(message);
    });
  });

const told = {};
told.urdf = (await once("/robot_description", "std_msgs/msg/String")).data.slice(0, 6);
told.joints = (await once("/joint_states", "sensor_msgs/msg/JointState")).name;
told.topics = await new Promise((resolve, reject) => ros.getTopics((found) => resolve(found.topics), reject));

const constraint = (joint_name, position) => ({
  joint_name, position, tolerance_above: 0.01, tolerance_below: 0.01, weight: 1.0,
});
const goal = [["shoulder", 1.0], ["elbow", 0.5], ["wrist", 0.0]].map(([name, at]) => constraint(name, at));
const answer = await call("/plan_kinematic_path", "moveit_msgs/srv/GetMotionPlan", {
  motion_plan_request: {
    group_name: "arm",
    goal_constraints: [{ joint_constraints: goal }],
    allowed_planning_time: 5.0,
  },
});
const plan = answer.motion_plan_response;
told.code = plan.error_code.val;
told.end = plan.trajectory.joint_trajectory.points.at(-1).positions;
told.refused = await call("/compute_fk", "moveit_msgs/srv/GetPositionFK", { fk_link_name: [] }).catch((said) => said);

const action = new ROSLIB.Action({ ros, name: "/execute_trajectory", actionType: "moveit_msgs/action/ExecuteTrajectory" });
const states = new Set();
told.executed = await new Promise((resolve, reject) =>
  action.sendGoal({ trajectory: plan.trajectory }, resolve, (feedback) => states.add(feedback.state), reject),
);
told.feedback = [...states];
console.log(JSON.stringify(told));
ros.close();
