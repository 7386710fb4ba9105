#include "runtime/app/live_settings.hpp"

#include <cmath>
#include <sstream>

namespace cloister {

Result<LiveSettings> live_settings(const ProgramConfig& config) {
  LiveSettings settings;
  const DdsConfig& dds = config.dds;
  settings.dds = {
      dds.domain,     dds.interface,         dds.peers, dds.external_address, dds.multicast,
      dds.first_port, SharedMemoryUse::kAuto};
  if (dds.shared_memory == "on") {
    settings.dds.shared_memory = SharedMemoryUse::kOn;
  } else if (dds.shared_memory == "off") {
    settings.dds.shared_memory = SharedMemoryUse::kOff;
  } else if (dds.shared_memory != "auto") {
    return fail(ErrorKind::kUsage,
                "dds.shared_memory = \"" + dds.shared_memory + "\": must be auto, on or off");
  }
  if (config.sensor.source == "udp") {
    settings.source = LiveSettings::Source::kSensor;
  } else if (config.sensor.source == "ros2") {
    settings.source = LiveSettings::Source::kRos2;
  } else if (config.sensor.source != "dds") {
    return fail(ErrorKind::kUsage,
                "sensor.source = \"" + config.sensor.source + "\": must be dds, udp or ros2");
  }
  settings.ros2_topics = {config.ros2.points_topic, config.ros2.odometry_topic,
                          config.ros2.path_topic, config.ros2.static_transforms_topic};
  if (!config.sensor.T_pose_sensor.empty()) {
    std::istringstream text(config.sensor.T_pose_sensor);
    double v[7];
    bool is_read = true;
    for (double& value : v) is_read = is_read && (text >> value);
    std::string more;
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (!is_read || (text >> more) || !(std::abs(q.norm() - 1.0) < 0.01)) {
      return fail(ErrorKind::kUsage,
                  "sensor.T_pose_sensor = \"" + config.sensor.T_pose_sensor +
                      "\": must be x y z qx qy qz qw, with a quaternion of length 1");
    }
    settings.T_pose_sensor = make_pose({v[0], v[1], v[2]}, q);
  }
  return settings;
}

}  // namespace cloister
