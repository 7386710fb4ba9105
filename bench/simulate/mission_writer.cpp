#include "bench/simulate/mission_writer.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "bench/simulate/pcap_record.hpp"
#include "bench/simulate/ply_file.hpp"
#include "bench/simulate/scan_simulator.hpp"

namespace cloister {

namespace {

namespace fs = std::filesystem;

constexpr Duration kBeforeFirstScan{200'000'000};
constexpr Duration kAfterLastScan{50'000'000};
constexpr Duration kTransmission{700'000};  // from a packet's last column to its arrival
constexpr std::uint64_t kScansPerBatch = 16;
constexpr std::uint64_t kFirstFrameId =
    65'520;  // so that every mission sees the 16-bit counter wrap

Result<void> write_text(const fs::path& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream)
    return fail(ErrorKind::kResource,
                path.string() + ": cannot be written: check space and permissions");
  return {};
}

/// A directory that vanishes unless it is given its final name.
class PendingDirectory {
 public:
  explicit PendingDirectory(fs::path final_path)
      : final_(std::move(final_path)),
        pending_(final_.parent_path() / (std::string(".") + final_.filename().string() +
                                         ".partial-" + std::to_string(getpid()))) {}
  PendingDirectory(const PendingDirectory&) = delete;
  PendingDirectory& operator=(const PendingDirectory&) = delete;
  ~PendingDirectory() {
    std::error_code ignored;
    fs::remove_all(pending_, ignored);
  }

  [[nodiscard]] const fs::path& path() const { return pending_; }

  Result<void> create(bool with_clouds) {
    std::error_code error;
    if (fs::exists(final_, error)) {
      const bool is_empty = fs::is_directory(final_, error) && fs::is_empty(final_, error);
      if (!is_empty && !fs::exists(final_ / "mission.json", error)) {
        return fail(ErrorKind::kUsage,
                    "--out " + final_.string() +
                        ": exists and is not a mission: name another directory or remove it");
      }
    }
    fs::create_directories(pending_ / "pose_graph", error);
    if (!error) fs::create_directories(pending_ / "ground_truth", error);
    if (!error && with_clouds) fs::create_directories(pending_ / "individual_clouds", error);
    if (error)
      return fail(ErrorKind::kResource, pending_.string() + ": cannot be made: " + error.message());
    return {};
  }

  /// Puts the finished directory in the place of whatever had its name.
  Result<void> publish() {
    std::error_code error;
    const fs::path old = pending_.string() + "-old";
    const bool replaces = fs::exists(final_, error);
    if (replaces) fs::rename(final_, old, error);
    if (!error) fs::rename(pending_, final_, error);
    if (error)
      return fail(ErrorKind::kResource,
                  final_.string() + ": cannot be put in place: " + error.message());
    if (replaces) fs::remove_all(old, error);
    return {};
  }

 private:
  fs::path final_;
  fs::path pending_;
};

/// One scan as pcap records: simulated, packed, and cut into datagrams.
class ScanRecorder {
 public:
  ScanRecorder(const ScanSimulator& simulator, const Trajectory& truth, SensorTime start)
      : simulator_(simulator), truth_(truth), start_(start) {}

  void record(std::uint64_t scan, std::vector<std::uint8_t>* out) const {
    const SensorModel& sensor = simulator_.sensor();
    const auto beams = static_cast<std::size_t>(sensor.beams());
    std::vector<PixelReturn> pixels(simulator_.num_pixels());
    simulator_.simulate(truth_, start_, scan, pixels);
    const auto packets = static_cast<std::uint64_t>(sensor.columns / kColumnsPerPacket);
    std::vector<ColumnReturns> columns(kColumnsPerPacket);
    std::vector<std::uint8_t> payload;
    payload.reserve(legacy_packet_bytes(sensor.beams()));
    out->clear();
    for (std::uint64_t packet = 0; packet < packets; ++packet) {
      for (int k = 0; k < kColumnsPerPacket; ++k) {
        const int column = static_cast<int>(packet) * kColumnsPerPacket + k;
        columns[k] = {
            static_cast<std::uint64_t>(simulator_.column_stamp(start_, scan, column).ns),
            static_cast<std::uint16_t>(column), static_cast<std::uint16_t>(kFirstFrameId + scan),
            static_cast<std::uint32_t>(column) * (kEncoderTicksPerRevolution / sensor.columns),
            std::span(pixels).subspan(static_cast<std::size_t>(column) * beams, beams)};
      }
      payload.clear();
      append_legacy_packet(columns, &payload);
      const SensorTime arrival{static_cast<std::int64_t>(columns.back().stamp_ns) +
                               kTransmission.ns};
      const auto ip_id = static_cast<std::uint16_t>(scan * packets + packet + 1);
      append_udp_datagram(UdpFlow{}, arrival, ip_id, payload, out);
    }
  }

 private:
  const ScanSimulator& simulator_;
  const Trajectory& truth_;
  SensorTime start_;
};

/// Which scans to simulate, and how.
struct ScanRun {
  std::uint64_t scans = 0;
  int threads = 1;
  const std::atomic<bool>& interrupted;
  const Progress& progress;
};

/// Records scans in batches on several threads and hands them over in order.
/// @param record(scan, Recording*) from any thread @param take(const Recording&) gives a Result<void>
/// @return scans done
template <typename Recording, typename Record, typename Take>
Result<std::uint64_t> run_scans(const ScanRun& run, Record&& record, Take&& take) {
  std::vector<Recording> batch(kScansPerBatch);
  std::uint64_t done = 0;
  while (done < run.scans && !run.interrupted.load(std::memory_order_relaxed)) {
    const std::uint64_t count = std::min(kScansPerBatch, run.scans - done);
    std::atomic<std::uint64_t> next{0};
    const auto work = [&]() {
      // Only the number matters; the results are handed over by join().
      for (std::uint64_t k = next.fetch_add(1, std::memory_order_relaxed); k < count;
           k = next.fetch_add(1, std::memory_order_relaxed)) {
        record(done + k, &batch[k]);
      }
    };
    std::vector<std::thread> helpers;
    for (int k = 1; k < run.threads; ++k) helpers.emplace_back(work);
    work();
    for (std::thread& helper : helpers) helper.join();
    for (std::uint64_t k = 0; k < count; ++k) {
      if (const auto taken = take(batch[k]); !taken) return tl::unexpected(taken.error());
    }
    done += count;
    run.progress(done, run.scans);
  }
  return done;
}

Result<std::uint64_t> write_pcap(const fs::path& path, const ScanRecorder& recorder, const ScanRun& run) {
  using Bytes = std::vector<std::uint8_t>;
  std::ofstream stream(path, std::ios::binary);
  const auto write = [&](const Bytes& bytes) -> Result<void> {
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (stream) return {};
    return fail(ErrorKind::kResource,
                path.string() + ": cannot be written: " + std::strerror(errno) + ": free some space");
  };
  Bytes header;
  append_pcap_header(&header);
  if (const auto written = write(header); !written) return tl::unexpected(written.error());
  auto done = run_scans<Bytes>(
      run, [&](std::uint64_t scan, Bytes* made) { recorder.record(scan, made); }, write);
  stream.close();
  if (done && !stream)
    return fail(ErrorKind::kResource, path.string() + ": cannot be written: free some space");
  return done;
}

std::string format_rooms(const World& world) {
  nlohmann::ordered_json rooms = nlohmann::ordered_json::array();
  for (const Room& room : world.rooms) {
    rooms.push_back({{"id", room.id},
                     {"name", room.name},
                     {"storey", room.storey},
                     {"min", {room.min_W.x(), room.min_W.y(), room.min_W.z()}},
                     {"max", {room.max_W.x(), room.max_W.y(), room.max_W.z()}}});
  }
  return rooms.dump(2) + "\n";
}

std::string format_wrong_closures(const SlamRun& slam) {
  std::string text = "from,to\n";
  for (const auto& [from, to] : slam.wrong_closures)
    text += std::to_string(from) + ',' + std::to_string(to) + '\n';
  return text;
}

std::string format_mission(const World& world, const MissionOptions& options) {
  nlohmann::ordered_json mission = {{"name", world.name + "-" + std::to_string(options.seed)},
                                    {"world", world.name},
                                    {"seed", options.seed},
                                    {"sensor", options.sensor.prod_line + " (simulated)"},
                                    {"variant", options.clouds ? "individual_clouds" : "pcap"}};
  if (!options.clouds) mission["profile"] = "LEGACY";
  mission["pose_frame"] = "sensor";
  return mission.dump(2) + "\n";
}

/// What the robot makes of its way.
struct Estimate {
  Trajectory odometry;  ///< T_O_L
  SlamRun slam;
};

double length_of(const Trajectory& trajectory) {
  double length = 0.0;
  for (std::size_t k = 1; k < trajectory.poses.size(); ++k) {
    length += (trajectory.poses[k].translation() - trajectory.poses[k - 1].translation()).norm();
  }
  return length;
}

std::uint64_t bytes_below(const fs::path& directory) {
  std::uint64_t bytes = 0;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(directory, error)) {
    if (entry.is_regular_file(error)) bytes += entry.file_size(error);
  }
  return bytes;
}

}  // namespace

Result<MissionSummary> write_mission(const World& world, Trajectory truth,
                                     const MissionOptions& options,
                                     const std::atomic<bool>& interrupted,
                                     const Progress& progress) {
  const fs::path out = fs::absolute(options.out).lexically_normal();
  PendingDirectory directory(out.filename().empty() ? out.parent_path() : out);
  auto scene = RayScene::build(world.mesh);
  if (!scene) return tl::unexpected(scene.error());
  if (auto made = directory.create(options.clouds.has_value()); !made) return tl::unexpected(made.error());
  const fs::path& root = directory.path();

  const std::int64_t period_ns = 1'000'000'000 / options.sensor.rate_hz;
  const SensorTime first_column = truth.start + kBeforeFirstScan;
  std::int64_t motion_ns = truth.end().ns - first_column.ns - kAfterLastScan.ns;
  if (options.max_minutes > 0.0) {
    motion_ns = std::min(motion_ns, Duration::from_seconds(options.max_minutes * 60.0).ns);
  }
  const auto planned = static_cast<std::uint64_t>(std::max<std::int64_t>(1, motion_ns / period_ns));
  const auto end_after = [&](std::uint64_t scans) {
    truth.cut_after(first_column + Duration{static_cast<std::int64_t>(scans) * period_ns} + kAfterLastScan);
  };
  const auto estimate = [&]() {
    const LineOfSight line_of_sight = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
      return scene->line_of_sight(a.cast<float>(), b.cast<float>());
    };
    Estimate made{corrupt(truth, options.drift, options.seed), {}};
    made.slam = run_slam(truth, made.odometry, options.drift, options.slam, line_of_sight, options.seed);
    return made;
  };
  end_after(planned);
  Estimate estimated = estimate();

  const ScanSimulator simulator(options.sensor, world.mesh, *scene, options.seed);
  const ScanRun run{planned, options.threads, interrupted, progress};
  Result<std::uint64_t> scans;
  if (options.clouds) {
    // Without odometry, only nodes that a graph is published with have a place.
    const std::span placed(estimated.slam.node_stamps.data(), estimated.slam.nodes_published);
    CloudWriter writer(simulator, *options.clouds, truth, estimated.odometry, placed, first_column,
                       root / "individual_clouds");
    scans = run_scans<CloudWriter::Revolution>(
        run, [&](std::uint64_t scan, CloudWriter::Revolution* made) { writer.record(scan, made); },
        [&](const CloudWriter::Revolution& revolution) { return writer.take(revolution); });
    if (scans && writer.num_written() == 0)
      return fail(ErrorKind::kUsage, "--clouds: the mission ends before its graph has a node that saw anything");
  } else {
    scans = write_pcap(root / "lidar.pcap", ScanRecorder(simulator, truth, first_column), run);
  }
  if (!scans) return tl::unexpected(scans.error());
  if (*scans < planned) {
    end_after(*scans);
    estimated = estimate();
  }
  const auto& [odometry, slam] = estimated;

  Result<void> written = write_text(root / "mission.json", format_mission(world, options));
  const auto then = [&](const fs::path& path, const std::string& text) {
    if (written) written = write_text(path, text);
  };
  if (!options.clouds) {
    then(root / "metadata.json", format_metadata(options.sensor));
    then(root / "odometry.tum", format_tum(odometry));
  }
  then(root / "ground_truth" / "trajectory.tum", format_tum(truth));
  then(root / "ground_truth" / "rooms.json", format_rooms(world));
  if (!slam.wrong_closures.empty())
    then(root / "ground_truth" / "wrong_closures.csv", format_wrong_closures(slam));
  for (std::size_t k = 0; k < slam.snapshots.size(); ++k) {
    char name[64];
    std::snprintf(name, sizeof(name), "%06zu_%lld.g2o", k,
                  static_cast<long long>(slam.snapshots[k].stamp.ns));
    then(root / "pose_graph" / name, slam.snapshots[k].g2o);
  }
  if (written) written = write_ply(root / "ground_truth" / "mesh.ply", world.mesh);
  if (!written) return tl::unexpected(written.error());

  MissionSummary summary;
  summary.scans = *scans;
  summary.seconds = static_cast<double>(*scans) / options.sensor.rate_hz;
  summary.metres = length_of(truth);
  summary.nodes = slam.T_M_nodes.size();
  summary.loop_closures = slam.loop_closures;
  summary.bytes = bytes_below(root);
  summary.interrupted = *scans < planned;
  if (auto published = directory.publish(); !published) return tl::unexpected(published.error());
  return summary;
}

}  // namespace cloister
