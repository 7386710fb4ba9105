#include "bench/simulate/cloud_writer.hpp"

#include <cstdio>
#include <fstream>
#include <utility>

namespace cloister {

namespace {

constexpr std::size_t kGatheredStride = 4;  // of beams and of columns

}  // namespace

const std::map<std::string, CloudKind>& cloud_kind_names() {
  static const std::map<std::string, CloudKind> names = {{"scans", CloudKind::kScans},
                                                         {"gathered", CloudKind::kGathered}};
  return names;
}

CloudWriter::CloudWriter(const ScanSimulator& simulator, CloudKind kind, const Trajectory& truth,
                         const Trajectory& odometry, std::span<const SensorTime> node_stamps, SensorTime start,
                         std::filesystem::path folder)
    : simulator_(simulator),
      truth_(truth),
      odometry_(odometry),
      node_stamps_(node_stamps),
      start_(start),
      folder_(std::move(folder)),
      kind_(kind),
      fan_(make_beam_fan(simulator.sensor())) {}

void CloudWriter::record(std::uint64_t scan, Revolution* out) const {
  const SensorModel& sensor = simulator_.sensor();
  const auto beams = static_cast<std::size_t>(sensor.beams());
  std::vector<PixelReturn> pixels(simulator_.num_pixels());
  simulator_.simulate(truth_, start_, scan, pixels);
  out->columns.clear();
  out->points_O.clear();
  const std::size_t stride = kind_ == CloudKind::kGathered ? kGatheredStride : 1;
  for (int column = 0; column < sensor.columns; column += static_cast<int>(stride)) {
    const auto c = static_cast<std::size_t>(column);
    const SensorTime stamp = simulator_.column_stamp(start_, scan, column);
    const Pose T_O_L = odometry_.at(stamp);
    for (std::size_t beam = 0; beam < beams; beam += stride) {
      const PixelReturn& pixel = pixels[c * beams + beam];
      if (pixel.range_mm == 0) continue;
      const double beam_m = (pixel.range_mm - sensor.beam_origin_mm) * 1e-3;
      out->points_O.push_back(T_O_L * (fan_.origins_L[c].cast<double>() +
                                       beam_m * fan_.directions_L[c * beams + beam].cast<double>()));
    }
    out->columns.push_back({stamp, out->points_O.size()});
  }
}

Result<void> CloudWriter::take(const Revolution& revolution) {
  const std::int64_t revolution_ns = 1'000'000'000 / simulator_.sensor().rate_hz;
  std::size_t begin = 0;
  for (const Revolution::Column& column : revolution.columns) {
    while (next_node_ < node_stamps_.size() && node_stamps_[next_node_] <= column.stamp) {
      if (const auto done = write_cloud(node_stamps_[next_node_]); !done) return done;
      ++next_node_;
    }
    const auto first = revolution.points_O.begin();
    pieces_.push_back({column.stamp,
                       {first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(column.end)}});
    begin = column.end;
    while (kind_ == CloudKind::kScans && pieces_.front().stamp.ns <= column.stamp.ns - revolution_ns) pieces_.pop_front();
  }
  return {};
}

Result<void> CloudWriter::write_cloud(SensorTime node_stamp) {
  const Pose T_L_O = odometry_.at(node_stamp).inverse();
  std::vector<Eigen::Vector3f> points_L;
  for (const Piece& piece : pieces_) {
    for (const Eigen::Vector3d& p_O : piece.points_O) points_L.emplace_back((T_L_O * p_O).cast<float>());
  }
  pieces_.clear();
  if (points_L.empty()) return {};
  ++num_written_;
  char name[64];
  std::snprintf(name, sizeof(name), "cloud_%lld_%09lld.pcd", static_cast<long long>(node_stamp.ns / 1'000'000'000),
                static_cast<long long>(node_stamp.ns % 1'000'000'000));
  const std::string count = std::to_string(points_L.size());
  std::ofstream stream(folder_ / name, std::ios::binary);
  stream << "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " << count
         << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << count << "\nDATA binary\n";
  for (const Eigen::Vector3f& p_L : points_L)
    stream.write(reinterpret_cast<const char*>(p_L.data()), 3 * sizeof(float));
  stream.close();
  if (stream) return {};
  return fail(ErrorKind::kResource, (folder_ / name).string() + ": cannot be written: free some space");
}

}  // namespace cloister
