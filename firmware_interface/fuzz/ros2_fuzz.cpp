// Any bytes as a ROS 2 message: the first byte chooses the type, the rest is its CDR.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "firmware_interface/ros2/cdr_message.hpp"
#include "firmware_interface/ros2/odometry_message.hpp"
#include "firmware_interface/ros2/path_message.hpp"
#include "firmware_interface/ros2/point_cloud_message.hpp"
#include "firmware_interface/ros2/static_transforms.hpp"

namespace {

using namespace cloister;
using namespace cloister::ros2;

void require(bool is_true) {
  if (!is_true) std::abort();
}

/// What is believed can be written, and comes back the same.
template <typename Topic>
void check_round_trip(const Message<Topic>& message, MessageCounters& counters) {
  const std::vector<std::byte> written = message.encode();
  Message<Topic> again;
  require(again.decode(written, counters) && again.encode() == written);
}

void check_cloud(const PointCloud2& message, MessageCounters& counters) {
  PointCloudDecoder decoder(1 << 16);
  Scan scan;
  // Twice: the second time a beam table may be known.
  for (int i = 0; i < 2; ++i) {
    if (!decoder.scan(message, counters, scan)) continue;
    if (scan.kind == Scan::Kind::kOrganised) {
      require(scan.ranges_mm.size() == scan.geometry->direction_L.size());
      require(scan.column_valid.size() == static_cast<std::size_t>(scan.geometry->num_columns));
      require(scan.column_stamps.size() == scan.column_valid.size());
    }
    for (const Eigen::Vector3f& point : scan.points_L) require(point.allFinite());
  }
}

void check_path(const Path& message, MessageCounters& counters) {
  PathDecoder decoder;
  const auto graph = decoder.graph(message, counters);
  if (!graph) return;
  for (std::size_t i = 0; i < graph->nodes.size(); ++i) {
    require(graph->nodes[i].id == static_cast<NodeId>(i) && is_finite(graph->nodes[i].T_M_N));
  }
}

template <typename Topic, typename Check>
void check(std::span<const std::byte> cdr, Check&& check_content) {
  MessageCounters counters;
  Message<Topic> message;
  if (!message.decode(cdr, counters)) return;
  check_round_trip(message, counters);
  check_content(*message, counters);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const std::span<const std::byte> cdr = std::as_bytes(std::span(data + 1, size - 1));
  switch (data[0] % 5) {
    case 0:
      check<PointCloud2>(cdr, check_cloud);
      break;
    case 1:
      check<Path>(cdr, check_path);
      break;
    case 2:
      check<Odometry>(cdr, [](const Odometry& message, MessageCounters& counters) {
        const auto pose = OdometryDecoder().pose(message, counters);
        require(!pose || is_finite(pose->T_O_B));
      });
      break;
    case 3:
      check<TFMessage>(cdr, [](const TFMessage& message, MessageCounters& counters) {
        StaticTransforms transforms;
        transforms.add(message, counters);
        require(transforms.num_frames() <= message.transforms._length);
        for (std::uint32_t i = 0; i < message.transforms._length; ++i) {
          static_cast<void>(transforms.find("", message.transforms._buffer[i].child_frame_id));
        }
      });
      break;
    default:
      check<MarkerArray>(cdr, [](const MarkerArray&, MessageCounters&) {});
  }
  return 0;
}
