#pragma once

#include <cstdint>
#include <string>

#include "mapping/core/config_fields.hpp"

namespace cloister {

/// Threads and queues.
struct RuntimeConfig {
  int overlap_workers = 1;       ///< threads that compare pairs of submaps
  int scan_queue = 8;            ///< scans that may wait for the integration thread
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
  bool multicast = false;
  int first_port = 7400;                ///< 21000 fits Spot extensions
  std::string shared_memory = "auto";   ///< "auto", "on" or "off"
};

/// Where a live mission's scans come from.
struct SensorConfig {
  std::string source = "dds";                       ///< "dds", or "udp": straight from the sensor
  std::string metadata;                             ///< file; empty = from the host, else from DDS
  std::string host;                                 ///< the sensor's address, asked for its metadata over HTTP
  std::string address;                              ///< of the interface to listen on; empty = all
  int port = 7502;
  std::int64_t receive_buffer_bytes = 16 << 20;
  std::string T_pose_sensor;  ///< "x y z qx qy qz qw" in the frame whose poses arrive; empty = from DDS, else identity
};

/// All that can be configured.
struct ProgramConfig {
  Config map;
  RuntimeConfig runtime;
  DdsConfig dds;
  SensorConfig sensor;
};

/// Calls `visit(name, field, least, most)` for every field of the program's configuration. Of a text, the bounds are
/// those of its length.
template <typename ProgramConfigType, typename Visitor>
void visit_program_fields(ProgramConfigType& config, Visitor&& visit) {
  visit_fields(config.map, visit);
  visit("runtime.overlap_workers", config.runtime.overlap_workers, 1, 256);
  visit("runtime.scan_queue", config.runtime.scan_queue, 2, 1024);
  visit("runtime.graph_queue", config.runtime.graph_queue, 2, 65536);
  visit("runtime.fusion_reserve", config.runtime.fusion_reserve, 0.0, 0.9);
  visit("runtime.integration_priority", config.runtime.integration_priority, 0, 99);
  visit("runtime.vector_bits", config.runtime.vector_bits, 0, 512);
  visit("dds.domain", config.dds.domain, 0, 230);
  visit("dds.interface", config.dds.interface, 0, 64);
  visit("dds.peers", config.dds.peers, 0, 1024);
  visit("dds.multicast", config.dds.multicast, 0, 1);
  visit("dds.first_port", config.dds.first_port, 1024, 65000);
  visit("dds.shared_memory", config.dds.shared_memory, 2, 4);
  visit("sensor.source", config.sensor.source, 3, 3);
  visit("sensor.metadata", config.sensor.metadata, 0, 4096);
  visit("sensor.host", config.sensor.host, 0, 255);
  visit("sensor.address", config.sensor.address, 0, 15);
  visit("sensor.port", config.sensor.port, 1, 65535);
  visit("sensor.receive_buffer_bytes", config.sensor.receive_buffer_bytes, 65536, 1 << 30);
  visit("sensor.T_pose_sensor", config.sensor.T_pose_sensor, 0, 255);
}

}  // namespace cloister
