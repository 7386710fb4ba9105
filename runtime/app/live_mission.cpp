#include "runtime/app/live_mission.hpp"

#include <poll.h>

#include <system_error>
#include <utility>

#include "firmware_interface/ouster/ouster_geometry.hpp"
#include "runtime/app/outputs.hpp"
#include "runtime/cpu_clock.hpp"

namespace cloister {
namespace {

// Between two looks at what arrives on another way than the one that is waited for.
constexpr std::chrono::milliseconds kPacketWait{5};
constexpr std::chrono::milliseconds kTopicWait{20};
// Older than this is no way between two processes, but a clock that was set.
constexpr std::chrono::seconds kMaxWay{10};

/// When a scan arrived that was written, or received by the kernel, at an instant of the wall's clock.
std::chrono::steady_clock::time_point arrival(std::optional<std::int64_t> wall_ns) {
  const auto now = std::chrono::steady_clock::now();
  if (!wall_ns) return now;
  const auto age =
      std::chrono::system_clock::now().time_since_epoch() - std::chrono::nanoseconds(*wall_ns);
  return age >= age.zero() && age < kMaxWay ? now - age : now;
}

/// The largest scan that may come.
Pipeline::Options capacity_for(const LiveMission::Parts& parts, const ScanGeometry& geometry,
                               const ProgramConfig& config) {
  Pipeline::Options capacity;
  capacity.max_scan_pixels = parts.drivers ? static_cast<std::size_t>(config.map.scan.max_points)
                                           : geometry.direction_L.size();
  capacity.max_scan_columns = parts.drivers ? ros2::DriverListener::kMaxColumns
                                            : static_cast<std::size_t>(geometry.num_columns);
  capacity.max_scan_poses = ScanPlacer::kMaxPoses;
  return capacity;
}

}  // namespace

LiveMission::LiveMission(Parts parts, const ProgramConfig& config)
    : parts_(std::move(parts)),
      config_(config),
      geometry_(parts_.drivers ? ScanGeometry() : make_geometry(parts_.metadata)) {
  if (parts_.socket) assembler_.emplace(parts_.metadata);
  begin();
}

void LiveMission::begin() {
  // In the order in which they know each other, and one pipeline's memory before another's.
  service_.reset();
  status_.reset();
  ros2_.reset();
  pipeline_.reset();
  const Pipeline::Options capacity = capacity_for(parts_, geometry_, config_);
  feed_.emplace(config_.map, parts_.T_pose_sensor, capacity.max_scan_pixels,
                capacity.max_scan_columns);
  if (!parts_.expects_odometry) feed_->expect_no_odometry();
  ProgramConfig sized = config_;
  sized.map.scan.max_points = static_cast<int>(capacity.max_scan_pixels);
  next_.reserve(capacity.max_scan_pixels, capacity.max_scan_columns, capacity.max_scan_poses);
  pipeline_.emplace(sized, capacity);
  if (parts_.ros2_map != nullptr) {
    ros2_.emplace(
        *parts_.ros2_map, *pipeline_,
        Ros2Publisher::Options{config_.ros2.map_frame, config_.ros2.odometry_frame,
                               config_.ros2.publish_transform, config_.ros2.octomap_radius_m});
  }
  status_.emplace(*parts_.topics, ros2_ ? &*ros2_ : nullptr, *pipeline_,
                  parts_.link->uses_shared_memory());
  // The clock of the wall tells this map's changes from those of any other.
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  service_.emplace(*parts_.requests, *pipeline_, static_cast<std::uint64_t>(now.count()));
}

void LiveMission::step() {
  wait();
  const Clock::time_point now = Clock::now();
  const StopWatch decode_watch;
  take_in(now);
  pipeline_->record().cpu_decode_s += 1e-9 * static_cast<double>(decode_watch.cpu_ns());
  collect(now);
  feed_pipeline(now);
  answer_requests();
  service_->serve(now, *feed_);
  if (ros2_) {
    ros2_->publish_transform(*feed_);
    ros2_->serve_octomap();
  }
  status_->publish_if_due(now, *feed_, counts(true));
}

void LiveMission::collect(Clock::time_point now) {
  const bool is_idle = pipeline_->collect() == 0;
  if (is_idle || pipeline_->num_done() != num_done_) last_move_ = now;
  num_done_ = pipeline_->num_done();
}

void LiveMission::wait() {
  if (parts_.drivers) {
    parts_.drivers->wait(kTopicWait);
    return;
  }
  if (!parts_.socket) {
    parts_.topics->wait(kTopicWait);
    return;
  }
  pollfd waited{parts_.socket->file_descriptor(), POLLIN, 0};
  (void)poll(&waited, 1, static_cast<int>(kPacketWait.count()));
}

void LiveMission::take_in(Clock::time_point now) {
  if (parts_.drivers) {
    take_from_drivers(now);
    return;
  }
  // Odometry before graphs: what a graph's nodes need was sent before it.
  for (OdometrySample sample; parts_.topics->take(sample);) feed_->push(sample);
  for (GraphUpdate update; parts_.topics->take(update);) feed_->push(update, now);
  // Told again by a publisher that began anew: what a sensor is does not change within a mission.
  for (SensorDescription known; parts_.topics->take(known);) {
  }
  if (parts_.socket) {
    take_packets();
    return;
  }
  while (parts_.topics->take(feed_->scan_to_fill(), geometry_.num_beams, geometry_.num_columns)) {
    feed_->scan_to_fill().geometry = &geometry_;
    feed_->push_scan(arrival(parts_.topics->scan_written_ns()));
  }
}

void LiveMission::take_from_drivers(Clock::time_point now) {
  ros2::DriverListener& drivers = *parts_.drivers;
  for (OdometrySample sample; drivers.take(sample);) feed_->push(sample);
  for (GraphUpdate update; drivers.take(update);) feed_->push(update, now);
  // One at a time: it takes a while to read, and what is needed to place it goes before the next.
  if (drivers.take(feed_->scan_to_fill())) feed_->push_scan(arrival(drivers.scan_written_ns()));
  // Asked for even when nobody needs it: what comes is to be taken.
  const auto T_body_cloud = drivers.T_body_cloud();
  if (T_body_cloud && !feed_->has_T_B_L()) feed_->set_T_B_L(*T_body_cloud);
}

void LiveMission::take_packets() {
  for (UdpDatagram datagram; parts_.socket->next(datagram);) {
    // Whichever port it was sent to, this is the sensor's lidar port here.
    datagram.destination_port = parts_.metadata.lidar_port;
    if (assembler_->push(datagram)) take_assembled(arrival(datagram.capture_time_ns));
  }
}

void LiveMission::take_assembled(Clock::time_point arrived) {
  while (assembler_->take(feed_->scan_to_fill())) {
    feed_->scan_to_fill().geometry = &geometry_;
    feed_->push_scan(arrived);
  }
}

void LiveMission::feed_pipeline(Clock::time_point now) {
  while (true) {
    const LiveFeed::Item item = feed_->next(now, next_);
    if (item == LiveFeed::Item::kNone) return;
    if (item == LiveFeed::Item::kGraph) {
      pipeline_->submit(feed_->take_graph());
    } else if (Scan* slot = pipeline_->try_take_slot()) {
      std::swap(*slot, next_);
      pipeline_->submit(slot, feed_->scan_arrived());
    } else {
      pipeline_->drop(next_, "scan_late");
    }
  }
}

void LiveMission::answer_requests() {
  for (SaveMapRequest request; parts_.topics->take(request);) {
    SaveMapReply reply;
    reply.id = request.id;
    if (const auto saved = save_present_map(*pipeline_, parts_.out)) {
      std::error_code error;
      const auto path = std::filesystem::absolute(parts_.out / "map.cloister", error);
      reply.is_saved = true;
      reply.path = path.string();
      reply.bytes = std::filesystem::file_size(path, error);
    } else {
      reply.message = saved.error().message;
    }
    parts_.topics->publish(reply);
  }
  if (const auto reset = service_->take_reset()) {
    ++num_resets_;
    begin();
    parts_.requests->publish(ResetReply{reset->id});
  }
}

void LiveMission::finish() {
  if (assembler_ && assembler_->flush()) take_assembled(Clock::now());
  // What waits for its pose has waited long enough.
  feed_pipeline(kEnd);
  pipeline_->finish();
  MissionRecord& record = pipeline_->record();
  record.mission = "live";
  record.scans_read = feed_->num_scans_read();
  record.scans_dropped += feed_->num_scans_dropped();
  if (num_resets_ > 0) record.counters["resets"] = num_resets_;
  record.counters["returns_read"] = feed_->num_returns_read();
  for (const auto& [name, count] : counts(false)) record.counters[name] += count;
  for (const auto& [name, count] : counts(true)) record.drops[name] += count;
}

std::map<std::string, std::int64_t> LiveMission::counts(bool only_drops) const {
  std::map<std::string, std::int64_t> counts;
  const auto add = [&]<typename Cause>(const Counters<Cause>& counters) {
    constexpr auto kNames = counter_names(Cause{});
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      const std::uint64_t count = counters[static_cast<Cause>(i)];
      if (count > 0 && kNames[i].is_drop == only_drops)
        counts[std::string(kNames[i].name)] += static_cast<std::int64_t>(count);
    }
  };
  if (ros2_ && only_drops && ros2_->num_refused() > 0)
    counts["ros2_output_refused"] = ros2_->num_refused();
  add(feed_->counters());
  add(feed_->graph_counters());
  add(parts_.topics->counters());
  if (parts_.socket) add(parts_.socket->counters());
  if (parts_.drivers) add(parts_.drivers->counters());
  if (assembler_) add(assembler_->counters());
  return counts;
}

}  // namespace cloister
