#include "bench/simulate/scan_simulator.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <tuple>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "bench/simulate/box_solid.hpp"
#include "bench/simulate/cloud_writer.hpp"

namespace cloister {
namespace {

constexpr SensorTime kStart{1'700'000'000'000'000'000};
const Eigen::Vector3d kRoom(8.0, 6.0, 3.0);

/// A closed room from the origin to kRoom.
TriangleMesh make_room() {
  const auto box = [](Eigen::Vector3d a, Eigen::Vector3d b) {
    return BoxSolid::from_corners_m(a, b, 0.6F);
  };
  const double t = 0.5;
  const Eigen::Vector3d r = kRoom;
  return union_surface(std::vector{
      box({-t, -t, -t}, {r.x() + t, r.y() + t, 0}),
      box({-t, -t, r.z()}, {r.x() + t, r.y() + t, r.z() + t}),
      box({-t, -t, 0}, {0, r.y() + t, r.z()}), box({r.x(), -t, 0}, {r.x() + t, r.y() + t, r.z()}),
      box({0, -t, 0}, {r.x(), 0, r.z()}), box({0, r.y(), 0}, {r.x(), r.y() + t, r.z()})});
}

SensorModel exact_sensor(const std::string& name) {
  SensorModel sensor = *make_sensor(name);
  sensor.noise_m = 0.0;
  sensor.dropout = 0.0;
  return sensor;
}

/// Where a range leads, by the manual's formula, written out once more: the lidar frame, then the sensor frame.
Eigen::Vector3d point_L(const SensorModel& sensor, int column, int beam, std::uint32_t range_mm) {
  const double rad = std::numbers::pi / 180.0;
  const double n = sensor.beam_origin_mm;
  const double r = range_mm;
  const double encoder = 2.0 * std::numbers::pi * (1.0 - 88.0 * column / 90'112.0);
  const double azimuth = -sensor.beam_azimuth_deg[beam] * rad;
  const double phi = sensor.beam_altitude_deg[beam] * rad;
  const double x = (r - n) * std::cos(encoder + azimuth) * std::cos(phi) + n * std::cos(encoder);
  const double y = (r - n) * std::sin(encoder + azimuth) * std::cos(phi) + n * std::sin(encoder);
  const double z = (r - n) * std::sin(phi);
  return Eigen::Vector3d(-x, -y, z + sensor.lidar_height_mm) * 1e-3;
}

double distance_to_room(const Eigen::Vector3d& p) {
  return std::min((p.array().abs()).minCoeff(), (kRoom - p).array().abs().minCoeff());
}

TEST_CASE("every exact return of a moving, turning sensor lies on the room's walls") {
  const TriangleMesh mesh = make_room();
  const auto scene = RayScene::build(mesh);
  REQUIRE(scene);
  Trajectory truth{kStart, Duration{10'000'000}, {}};
  for (int k = 0; k < 40; ++k) {
    truth.poses.push_back(
        make_pose({2.0 + 0.02 * k, 2.5, 1.2 + 0.01 * std::sin(0.3 * k)},
                  Eigen::Quaterniond(Eigen::AngleAxisd(0.02 * k, Eigen::Vector3d::UnitZ()) *
                                     Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitX()))));
  }
  for (const std::string name : {"os0-64", "os1-64"}) {
    CAPTURE(name);
    const SensorModel sensor = exact_sensor(name);
    const ScanSimulator simulator(sensor, mesh, *scene, 1);
    std::vector<PixelReturn> pixels(simulator.num_pixels());
    simulator.simulate(truth, kStart, 2, pixels);
    int returns = 0;
    double worst = 0.0;
    for (int column = 0; column < 1024; ++column) {
      const SensorTime stamp = simulator.column_stamp(kStart, 2, column);
      for (int beam = 0; beam < 64; ++beam) {
        const PixelReturn& pixel = pixels[static_cast<std::size_t>(column * 64 + beam)];
        if (pixel.range_mm == 0) continue;
        ++returns;
        worst = std::max(worst, distance_to_room(truth.at(stamp) *
                                                 point_L(sensor, column, beam, pixel.range_mm)));
      }
    }
    CHECK(returns > 65'000);
    CHECK(worst < 0.0006);  // ranges are whole millimetres
  }
}

TEST_CASE("ranges scatter as the sensor's noise says and pixels go missing as often as stated") {
  const TriangleMesh mesh = make_room();
  const auto scene = RayScene::build(mesh);
  REQUIRE(scene);
  const Trajectory truth{
      kStart, Duration{10'000'000}, {make_pose({3, 3, 1.5}, Eigen::Quaterniond::Identity())}};
  SensorModel sensor = exact_sensor("os0-64");
  std::vector<PixelReturn> exact(65'536);
  std::vector<PixelReturn> noisy(65'536);
  ScanSimulator(sensor, mesh, *scene, 1).simulate(truth, kStart, 0, exact);
  sensor.noise_m = 0.02;
  sensor.dropout = 0.05;
  ScanSimulator(sensor, mesh, *scene, 1).simulate(truth, kStart, 0, noisy);
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    if (noisy[k].range_mm == 0) continue;
    const double error =
        1e-3 * (static_cast<double>(noisy[k].range_mm) - static_cast<double>(exact[k].range_mm));
    sum += error;
    squares += error * error;
    count += 1.0;
  }
  CHECK(count / 65'536.0 == doctest::Approx(0.95).epsilon(0.01));
  CHECK(std::abs(sum / count) < 0.0005);
  CHECK(std::sqrt(squares / count) == doctest::Approx(0.02).epsilon(0.03));
}

TEST_CASE("nothing comes back from too near, from beyond reach, or from where there is nothing") {
  const auto plate = [](double x) {
    return union_surface(
        std::vector{BoxSolid::from_corners_m({x, -50, -50}, {x + 1, 50, 50}, 0.8F)});
  };
  const Trajectory truth{kStart, Duration{10'000'000}, {Pose::Identity()}};
  const auto returns = [&](double x) {
    const TriangleMesh mesh = plate(x);
    const auto scene = RayScene::build(mesh);
    REQUIRE(scene);
    const ScanSimulator simulator(exact_sensor("os0-64"), mesh, *scene, 1);
    std::vector<PixelReturn> pixels(simulator.num_pixels());
    simulator.simulate(truth, kStart, 0, pixels);
    return std::count_if(pixels.begin(), pixels.end(),
                         [](const PixelReturn& p) { return p.range_mm > 0; });
  };
  CHECK(returns(60.0) == 0);
  const auto near = returns(5.0);
  CHECK(near > 20'000);
  CHECK(near < 33'000);  // behind the sensor there is nothing
  CHECK(returns(0.25) < near);
}

TEST_CASE("far, dark and grazed targets are lost more often than near ones met squarely") {
  const auto share = [&](double distance, float albedo) {
    const TriangleMesh mesh = union_surface(std::vector{
        BoxSolid::from_corners_m({distance, -200, -200}, {distance + 1, 200, 200}, albedo)});
    const auto scene = RayScene::build(mesh);
    REQUIRE(scene);
    const ScanSimulator simulator(exact_sensor("os0-64"), mesh, *scene, 1);
    std::vector<PixelReturn> pixels(simulator.num_pixels());
    const Trajectory truth{kStart, Duration{10'000'000}, {Pose::Identity()}};
    simulator.simulate(truth, kStart, 0, pixels);
    int seen = 0;
    for (int column = 480; column < 544;
         ++column) {  // the lidar's zero looks back, its half turn ahead
      for (int beam = 28; beam < 36; ++beam)
        seen += pixels[static_cast<std::size_t>(column * 64 + beam)].range_mm > 0;
    }
    return seen / 512.0;
  };
  CHECK(share(5.0, 0.5F) > 0.99);
  CHECK(share(30.0, 0.05F) < 0.2);
  CHECK(share(30.0, 0.5F) > share(30.0, 0.1F));
}

TEST_CASE("column stamps are spread evenly and stay exact over a long mission") {
  const TriangleMesh mesh = make_room();
  const auto scene = RayScene::build(mesh);
  REQUIRE(scene);
  const ScanSimulator simulator(*make_sensor("os0-64"), mesh, *scene, 1);
  CHECK(simulator.column_stamp(kStart, 0, 0) == kStart);
  CHECK(simulator.column_stamp(kStart, 27'000, 0).ns == kStart.ns + 2'700'000'000'000);
  CHECK(simulator.column_stamp(kStart, 0, 512).ns == kStart.ns + 50'000'000);
}

TEST_CASE("the metadata is flat, complete and lists every beam") {
  const auto metadata = nlohmann::json::parse(format_metadata(*make_sensor("os0-64")));
  CHECK(metadata["lidar_mode"] == "1024x10");
  CHECK(metadata["data_format"]["pixels_per_column"] == 64);
  CHECK(metadata["data_format"]["pixel_shift_by_row"].size() == 64);
  CHECK(metadata["lidar_to_sensor_transform"].size() == 16);
  CHECK_FALSE(metadata.contains("beam_to_lidar_transform"));
  const auto altitudes = metadata["beam_altitude_angles"].get<std::vector<double>>();
  REQUIRE(altitudes.size() == 64);
  CHECK(std::is_sorted(altitudes.rbegin(), altitudes.rend()));
  CHECK(altitudes.front() > 44.0);
  CHECK(altitudes.back() < -44.0);
  CHECK_FALSE(make_sensor("os9"));
}

std::vector<Eigen::Vector3d> read_cloud(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string line;
  while (std::getline(stream, line) && line != "DATA binary") {
  }
  std::vector<Eigen::Vector3d> points;
  Eigen::Vector3f p;
  while (stream.read(reinterpret_cast<char*>(p.data()), 3 * sizeof(float))) points.push_back(p.cast<double>());
  return points;
}

TEST_CASE("a node's cloud lies in the sensor's frame at that node, and holds what it should of what was seen") {
  const TriangleMesh mesh = make_room();
  const auto scene = RayScene::build(mesh);
  REQUIRE(scene);
  const SensorModel sensor = exact_sensor("os0-64");
  const ScanSimulator simulator(sensor, mesh, *scene, 1);
  Trajectory truth{kStart, Duration{10'000'000}, {}};
  for (int k = 0; k <= 100; ++k)
    truth.poses.push_back(make_pose({2.0 + 0.02 * k, 2.5, 1.2},
                                    Eigen::Quaterniond(Eigen::AngleAxisd(0.02 * k, Eigen::Vector3d::UnitZ()))));
  // The first node is there before the first scan, the last one after the last.
  const std::vector<SensorTime> nodes = {kStart, {kStart.ns + 350'000'000}, {kStart.ns + 750'000'000},
                                         {kStart.ns + 990'000'000}};
  const auto folder = std::filesystem::temp_directory_path() / ("cloister-clouds-" + std::to_string(getpid()));
  const auto all_of = [&](int scans_in_tenths, int stride) { return 1024 * 64 / stride * scans_in_tenths / 10; };
  for (const auto& [kind, first, second] :
       {std::tuple{CloudKind::kScans, all_of(10, 1), all_of(10, 1)}, {CloudKind::kGathered, all_of(25, 16), all_of(40, 16)}}) {
    std::filesystem::create_directories(folder);
    CloudWriter writer(simulator, kind, truth, truth, nodes, SensorTime{kStart.ns + 100'000'000}, folder);
    CloudWriter::Revolution revolution;
    for (std::uint64_t scan = 0; scan < 8; ++scan) {
      writer.record(scan, &revolution);
      REQUIRE(writer.take(revolution).has_value());
    }
    const auto entries = std::filesystem::directory_iterator(folder);
    CHECK(std::distance(begin(entries), end(entries)) == 2);
    for (const auto& [node, expected] : {std::pair{1U, first}, {2U, second}}) {
      const std::string name =
          "cloud_1700000000_" + std::to_string((nodes[node].ns - kStart.ns) % 1'000'000'000) + ".pcd";
      const auto points_L = read_cloud(folder / name);
      // Nearly all beams meet a wall.
      CHECK(static_cast<double>(points_L.size()) == doctest::Approx(expected).epsilon(0.03));
      double worst = 0.0;
      for (const Eigen::Vector3d& p_L : points_L)
        worst = std::max(worst, distance_to_room(truth.at(nodes[node]) * p_L));
      CHECK(worst < 2e-3);
    }
    std::filesystem::remove_all(folder);
  }
}

}  // namespace
}  // namespace cloister
