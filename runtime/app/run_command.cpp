#include "runtime/app/run_command.hpp"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "firmware_interface/files/read_file.hpp"
#include "firmware_interface/map/map_hash.hpp"
#include "firmware_interface/ouster/sensor_http.hpp"
#include "runtime/app/live_mission.hpp"
#include "runtime/app/live_settings.hpp"
#include "runtime/app/outputs.hpp"
#include "runtime/app/progress.hpp"
#include "runtime/app/service_manager.hpp"
#include "runtime/app/stop_signal.hpp"

namespace cloister {
namespace {

constexpr std::chrono::seconds kHttpTimeout{5};

struct Sensor {
  SensorMetadata metadata;
  Pose T_pose_sensor = Pose::Identity();
};

/// What the sensor is: from a file, from itself, or from DDS, where somebody has to say it first.
/// @return nothing when a signal came before anybody did
Result<std::optional<Sensor>> find_sensor(const ProgramConfig& config, const LiveSettings& settings,
                                          MapperTopics& topics, ServiceManager& manager) {
  SensorDescription description;
  std::string name = config.sensor.metadata;
  if (!config.sensor.metadata.empty()) {
    auto text = read_file(config.sensor.metadata);
    if (!text) return tl::unexpected(text.error());
    description.metadata_json = std::move(*text);
  } else if (!config.sensor.host.empty()) {
    auto text = fetch_sensor_metadata(config.sensor.host, kHttpTimeout);
    if (!text) return tl::unexpected(text.error());
    name = "metadata of " + config.sensor.host;
    description.metadata_json = std::move(*text);
  } else {
    name = "metadata on topic cloister/sensor";
    while (!topics.take(description)) {
      if (StopSignal::number() != 0) return std::nullopt;
      topics.wait(std::chrono::milliseconds(50));
      manager.alive();
    }
  }
  auto metadata = parse_metadata(description.metadata_json, name);
  if (!metadata) return tl::unexpected(metadata.error());
  return Sensor{std::move(*metadata), settings.T_pose_sensor.value_or(description.T_pose_sensor)};
}

Result<void> outcome(const MissionRecord& record, const std::filesystem::path& out) {
  if (StopSignal::number() != SIGINT) return {};
  return fail(ErrorKind::kInterrupted,
              "interrupted after scan " + std::to_string(record.scans_integrated) +
                  "; the outputs in " + out.string() + " are complete up to there");
}

}  // namespace

Result<void> run_live(const RunOptions& options, const ProgramConfig& config) {
  const auto settings = live_settings(config);
  if (!settings) return tl::unexpected(settings.error());
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error)
    return fail(ErrorKind::kResource,
                options.out.string() + ": cannot make the directory: " + error.message());

  const StopSignal stop;
  ServiceManager manager;
  // Before any thread is started.
  auto link = DdsLink::open(settings->dds);
  if (!link) return tl::unexpected(link.error());
  if (options.show_progress) std::fprintf(stderr, "cloister: %s\n", link->transport().c_str());
  auto topics = MapperTopics::open(*link);
  if (!topics) return tl::unexpected(topics.error());

  LiveMission::Parts parts;
  parts.link = &*link;
  parts.topics = &*topics;
  auto requests = MapRequests::open(*link);
  if (!requests) return tl::unexpected(requests.error());
  parts.requests = &*requests;
  parts.out = options.out;
  if (settings->source == LiveSettings::Source::kSensor) {
    auto socket =
        UdpSource::open({static_cast<std::uint16_t>(config.sensor.port), config.sensor.address,
                         static_cast<int>(config.sensor.receive_buffer_bytes)});
    if (!socket) return tl::unexpected(socket.error());
    parts.socket.emplace(std::move(*socket));
  }
  // Whoever publishes may wait for this; that nobody does is no failure to start.
  manager.ready();
  if (settings->source == LiveSettings::Source::kRos2) {
    auto drivers =
        ros2::DriverListener::open(*link, {settings->ros2_topics, config.ros2.reliable,
                                           static_cast<std::size_t>(config.map.scan.max_points)});
    if (!drivers) return tl::unexpected(drivers.error());
    parts.drivers.emplace(std::move(*drivers));
    parts.T_pose_sensor = settings->T_pose_sensor;
    parts.expects_odometry = !settings->ros2_topics.odometry.empty();
  } else {
    auto sensor = find_sensor(config, *settings, *topics, manager);
    if (!sensor) return tl::unexpected(sensor.error());
    if (!*sensor) return outcome({}, options.out);
    parts.metadata = std::move((*sensor)->metadata);
    parts.T_pose_sensor = (*sensor)->T_pose_sensor;
  }

  std::optional<ros2::MapTopics> ros2_map;
  if (config.ros2.publish) {
    auto opened = ros2::MapTopics::open(*link);
    if (!opened) return tl::unexpected(opened.error());
    ros2_map.emplace(std::move(*opened));
    parts.ros2_map = &*ros2_map;
  }

  LiveMission mission(std::move(parts), config);
  for (const std::string& warning : mission.pipeline().record().warnings)
    std::fprintf(stderr, "cloister: warning: %s\n", warning.c_str());
  Progress progress(options.show_progress);
  while (StopSignal::number() == 0) {
    mission.step();
    progress.show(mission.pipeline().record(), 0);
    if (mission.is_moving()) manager.alive();
  }
  manager.stopping();
  mission.finish();

  MissionRecord& record = mission.pipeline().record();
  record.config = config.map;
  record.interrupted = StopSignal::number() == SIGINT;
  if (const std::string warning = mission.input_warning(); !warning.empty()) {
    std::fprintf(stderr, "cloister: warning: %s\n", warning.c_str());
    record.warnings.push_back(warning);
  }
  record.map_hash = map_hash(mission.pipeline().store(), mission.pipeline().submaps());
  if (auto written = write_outputs(mission.pipeline(), options.out); !written) return written;
  return outcome(record, options.out);
}

}  // namespace cloister
