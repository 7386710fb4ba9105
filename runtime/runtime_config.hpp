#pragma once

#include <cstdint>
#include <string>

#include "mapping/core/config_fields.hpp"

namespace cloister {

/// Threads and queues.
struct RuntimeConfig {
  int overlap_workers = 1;       ///< threads that compare pairs of submaps
  int integration_workers = 1;   ///< threads that share one scan: pays outdoors, where cores are idle; more than one allocate
  int scan_queue = 16;           ///< scans that may wait for the integration thread, as after a pause of the network
  int graph_queue = 256;         ///< graph revisions that may be under way
  double fusion_reserve = 0.25;  ///< share of the voxel pools that is kept for fusions
  int integration_priority = 0;  ///< of its thread in real time (SCHED_FIFO), where permitted; 0 = as everything else
  int vector_bits = 0;           ///< widest vectors to compute with, 0 = whatever the processor has
};

/// How a live mission joins DDS.
struct DdsConfig {
  int domain = 0;
  std::string interface = "lo";         ///< name or address; empty = whichever DDS prefers
  std::string peers;                    ///< where to look for others, addresses separated by commas
  std::string external_address;         ///< told to others in place of the interface's, behind a translated network
  bool multicast = false;
  int first_port = 7400;                ///< 21000 fits Spot extensions
  std::string shared_memory = "auto";   ///< "auto", "on" or "off"
};

/// Where a live mission's scans come from.
struct SensorConfig {
  std::string source = "dds";                       ///< "dds", "udp": straight from the sensor, or "ros2"
  std::string metadata;                             ///< file; empty = from the host, else from DDS
  std::string host;                                 ///< the sensor's address, asked for its metadata over HTTP
  std::string address;                              ///< of the interface to listen on; empty = all
  int port = 7502;
  std::int64_t receive_buffer_bytes = 16 << 20;
  std::string T_pose_sensor;  ///< "x y z qx qy qz qw" in the frame whose poses arrive; empty = from DDS, else identity
};

/// The topics of ROS 2, by the names they have there. What drivers publish is read with sensor.source = "ros2".
struct Ros2Config {
  std::string points_topic = "/ouster/points";
  std::string odometry_topic = "/odometry";   ///< empty: the path's poses are those of the clouds
  std::string path_topic = "/path";           ///< re-optimised trajectory; empty: odometry alone
  std::string static_transforms_topic = "/tf_static";
  bool publish = false;            ///< shows the map to ROS 2's tools
  bool publish_transform = true;   ///< of them map -> odom, which a SLAM system may publish already
  std::string map_frame = "map";
  std::string odometry_frame = "odom";
  double octomap_radius_m = 20.0;  ///< submaps this near to the robot are in the OctoMap that is asked for
  bool reliable = false;  ///< asks for lost clouds and odometry again; drivers that do not offer it are not heard
};

/// All that can be configured.
struct ProgramConfig {
  Config map;
  RuntimeConfig runtime;
  DdsConfig dds;
  SensorConfig sensor;
  Ros2Config ros2;
};

/// Calls `visit(name, field, least, most)` for every field of the program's configuration. Of a text, the bounds are
/// those of its length.
template <typename ProgramConfigType, typename Visitor>
void visit_program_fields(ProgramConfigType& config, Visitor&& visit) {
  visit_fields(config.map, visit);
  visit("runtime.overlap_workers", config.runtime.overlap_workers, 1, 256);
  visit("runtime.integration_workers", config.runtime.integration_workers, 1, 256);
  visit("runtime.scan_queue", config.runtime.scan_queue, 2, 1024);
  visit("runtime.graph_queue", config.runtime.graph_queue, 2, 65536);
  visit("runtime.fusion_reserve", config.runtime.fusion_reserve, 0.0, 0.9);
  visit("runtime.integration_priority", config.runtime.integration_priority, 0, 99);
  visit("runtime.vector_bits", config.runtime.vector_bits, 0, 512);
  visit("dds.domain", config.dds.domain, 0, 230);
  visit("dds.interface", config.dds.interface, 0, 64);
  visit("dds.peers", config.dds.peers, 0, 1024);
  visit("dds.external_address", config.dds.external_address, 0, 64);
  visit("dds.multicast", config.dds.multicast, 0, 1);
  visit("dds.first_port", config.dds.first_port, 1024, 65000);
  visit("dds.shared_memory", config.dds.shared_memory, 2, 4);
  visit("sensor.source", config.sensor.source, 3, 4);
  visit("sensor.metadata", config.sensor.metadata, 0, 4096);
  visit("sensor.host", config.sensor.host, 0, 255);
  visit("sensor.address", config.sensor.address, 0, 15);
  visit("sensor.port", config.sensor.port, 1, 65535);
  visit("sensor.receive_buffer_bytes", config.sensor.receive_buffer_bytes, 65536, 1 << 30);
  visit("sensor.T_pose_sensor", config.sensor.T_pose_sensor, 0, 255);
  visit("ros2.points_topic", config.ros2.points_topic, 1, 255);
  visit("ros2.odometry_topic", config.ros2.odometry_topic, 0, 255);
  visit("ros2.path_topic", config.ros2.path_topic, 0, 255);
  visit("ros2.static_transforms_topic", config.ros2.static_transforms_topic, 1, 255);
  visit("ros2.reliable", config.ros2.reliable, 0, 1);
  visit("ros2.publish", config.ros2.publish, 0, 1);
  visit("ros2.publish_transform", config.ros2.publish_transform, 0, 1);
  visit("ros2.map_frame", config.ros2.map_frame, 1, 255);
  visit("ros2.odometry_frame", config.ros2.odometry_frame, 1, 255);
  visit("ros2.octomap_radius_m", config.ros2.octomap_radius_m, 0.0, 10000.0);
}

}  // namespace cloister
