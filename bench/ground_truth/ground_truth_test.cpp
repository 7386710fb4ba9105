#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "bench/ground_truth/alignment.hpp"
#include "bench/ground_truth/mesh_accuracy.hpp"
#include "bench/ground_truth/room_accuracy.hpp"
#include "bench/ground_truth/state_accuracy.hpp"
#include "bench/simulate/ply_file.hpp"
#include "bench/simulate/random_stream.hpp"

namespace cloister {
namespace {

namespace fs = std::filesystem;

BoxSolid box(double x0, double y0, double z0, double x1, double y1, double z1) {
  return BoxSolid::from_corners_m({x0, y0, z0}, {x1, y1, z1}, 0.5F);
}

/// A way of one metre steps along x through two rooms, 4 m each, with a pillar in the second.
GroundTruth make_truth() {
  GroundTruth truth;
  for (int k = 0; k <= 70; ++k) {
    truth.T_W_L.push_back({SensorTime{1'000'000'000LL * (k + 1)},
                           make_pose({0.5 + 0.1 * k, 2.0, 1.5}, Eigen::Quaterniond::Identity())});
  }
  truth.rooms.push_back({0, "first", 0, {0, 0, 0}, {4, 4, 3}});
  truth.rooms.push_back({1, "second", 0, {4, 0, 0}, {8, 4, 3}});
  truth.mesh_W = union_surface(
      std::vector{box(0, 0, -1, 8, 4, 0), box(0, 0, 3, 8, 4, 4), box(6, 3, 0, 7, 4, 3)});
  return truth;
}

Pose some_pose() {
  return make_pose({1.0, -2.0, 0.5}, Eigen::Quaterniond(Eigen::AngleAxisd(
                                         0.4, Eigen::Vector3d(0.1, 0.2, 1).normalized())));
}

TEST_CASE("a moved map is moved back exactly, even from a trajectory without extent") {
  const GroundTruth truth = make_truth();
  const Pose T_W_M = some_pose();
  for (const std::size_t count : {truth.T_W_L.size(), std::size_t{1}}) {
    std::vector<StampedPose> estimate(truth.T_W_L.begin(),
                                      truth.T_W_L.begin() + static_cast<std::ptrdiff_t>(count));
    for (StampedPose& pose : estimate) pose.pose = T_W_M.inverse() * pose.pose;
    const Alignment alignment = align(estimate, truth.T_W_L);
    CHECK(alignment.T_W_M.isApprox(T_W_M, 1e-9));
    CHECK(alignment.max_m < 1e-9);
  }
}

TEST_CASE("a bent map is moved back where the scans were, each end by its own error") {
  std::vector<StampedPose> truth, estimate;
  for (int x = 0; x <= 100; ++x) {
    Pose T_W_L = Pose::Identity();
    T_W_L.translation().x() = x;
    truth.push_back({{x}, T_W_L});
    // The far half was put aside and turned, as a whole.
    estimate.push_back({{x}, x < 50 ? T_W_L : some_pose() * T_W_L});
  }
  const LocalAlignment alignment(estimate, truth);
  const Eigen::Vector3d beside{3, 8, 1};
  for (const double x : {0.0, 20.0, 80.0, 100.0}) {
    const Eigen::Vector3d p_W = Eigen::Vector3d{x, 0, 0} + beside;
    const Eigen::Vector3d p_M = x < 50 ? p_W : some_pose() * p_W;
    CHECK((alignment.to_world(p_M) - p_W).norm() < 0.01);
  }
}

TEST_CASE(
    "points on a cube that is too large by 8 cm all count as within 10 cm and none within 5") {
  GroundTruth truth = make_truth();
  truth.mesh_W = union_surface(std::vector{box(-1, -1, -1, 1, 1, 1)});
  truth.T_W_L = {{SensorTime{1}, make_pose({3, 0, 0}, Eigen::Quaterniond::Identity())}};
  const auto scene = RayScene::build(truth.mesh_W);
  REQUIRE(scene);
  const TriangleMesh mesh_W =
      union_surface(std::vector{box(-1.08, -1.08, -1.08, 1.08, 1.08, 1.08)});
  TriangleMesh mesh_M = mesh_W;
  const Pose T_W_M = some_pose();
  for (Eigen::Vector3f& v : mesh_M.vertices) v = (T_W_M.inverse() * v.cast<double>()).cast<float>();

  const auto accuracy = compare_mesh(mesh_M, T_W_M, truth, *scene, 20'000, 1);

  REQUIRE(accuracy);
  CHECK(accuracy->samples == 20'000);
  CHECK(accuracy->within_5cm == 0.0);
  // Beyond the cube's rims the distance is hypot(8 cm, d): more than 10 cm where d exceeds 6 of the 8 cm.
  CHECK(accuracy->within_10cm == doctest::Approx(1.06 * 1.06 / (1.08 * 1.08)).epsilon(0.005));
  CHECK(accuracy->within_25cm == 1.0);
  CHECK(accuracy->mean_m == doctest::Approx(0.08).epsilon(0.02));
  CHECK(accuracy->max_m < 0.08 * std::sqrt(3.0) + 1e-6);
  CHECK(accuracy->complete_10cm == 1.0);
  CHECK(accuracy->surface_samples > 200);  // of 2,000, those on the side that is seen
  CHECK(accuracy->surface_samples < 500);
}

TEST_CASE("samples of a mesh are spread by area") {
  const TriangleMesh mesh = union_surface(std::vector{box(0, 0, 0, 1, 1, 3)});
  const auto points = sample_surface(mesh, 14'000, 1);
  int on_top = 0;
  for (const Eigen::Vector3d& p : points) on_top += p.z() > 2.9999 ? 1 : 0;
  CHECK(on_top == doctest::Approx(1000).epsilon(0.1));
  CHECK(sample_surface(TriangleMesh{}, 10, 1).empty());
}

TEST_CASE("sampled points keep clear of surfaces and know whether they are in something solid") {
  const GroundTruth truth = make_truth();
  const auto scene = RayScene::build(truth.mesh_W);
  REQUIRE(scene);
  const auto points = sample_points(truth, *scene, 5000, 0.1, 1);
  REQUIRE(points.size() == 5000);
  int solid = 0;
  for (const TruePoint& point : points) {
    CHECK(scene->distance(point.p_W.cast<float>(), 1.0F) > 0.1F);
    const bool in_pillar = point.p_W.x() > 6 && point.p_W.x() < 7 && point.p_W.y() > 3;
    CHECK(point.is_solid == (in_pillar || point.p_W.z() < 0 || point.p_W.z() > 3));
    solid += point.is_solid ? 1 : 0;
  }
  CHECK(solid > 100);
}

TEST_CASE("answers are counted as right and wrong by what is truly there") {
  const std::vector<TruePoint> points = {{{0, 0, 0}, false},
                                         {{0, 0, 0}, true},
                                         {{0, 0, 0}, false},
                                         {{0, 0, 0}, true},
                                         {{0, 0, 0}, false}};
  using enum PointState;
  const StateAccuracy result =
      compare_states(points, {kFree, kFree, kOccupied, kOccupied, kUnknown});
  CHECK(result.known_free == 2);
  CHECK(result.known_free_right == 1);
  CHECK(result.known_occupied == 2);
  CHECK(result.known_occupied_wrong == 1);
  CHECK(result.unknown == 1);
  CHECK(result.truly_free == 3);
}

TEST_CASE(
    "the adjusted Rand index is one for equal partitions, near zero for chance, and as published "
    "between") {
  using Labels = std::vector<std::pair<std::int64_t, std::int64_t>>;
  CHECK(adjusted_rand_index(Labels{{0, 7}, {0, 7}, {1, 3}, {1, 3}}) == doctest::Approx(1.0));
  CHECK(adjusted_rand_index(Labels{{0, 7}, {0, 7}}) == 1.0);
  CHECK(adjusted_rand_index(Labels{}) == 1.0);
  // Two classes of three against three of two: 2 pairs agree, 6 and 3 pairs are together, of 15 in all.
  const Labels mixed = {{0, 0}, {0, 0}, {0, 1}, {1, 1}, {1, 2}, {1, 2}};
  CHECK(adjusted_rand_index(mixed) ==
        doctest::Approx((2.0 - 6.0 * 3.0 / 15.0) / (4.5 - 6.0 * 3.0 / 15.0)));
  RandomStream random(1, 1);
  Labels chance;
  for (int k = 0; k < 5000; ++k) {
    chance.emplace_back(static_cast<std::int64_t>(random.below(4)),
                        static_cast<std::int64_t>(random.below(5)));
  }
  CHECK(std::abs(adjusted_rand_index(chance)) < 0.01);
}

TEST_CASE("a submap counts for a room when it holds a tenth of the room's scans, doorways aside") {
  const GroundTruth truth = make_truth();
  std::vector<SubmapScans> submaps = {{10, {}}, {11, {}}, {12, {}}};
  for (const StampedPose& pose : truth.T_W_L) {
    const double x = pose.pose.translation().x();
    submaps[x < 4.5 ? 0 : 1].stamps.push_back(pose.stamp);  // changes half a metre late
  }
  submaps[2].stamps = {truth.T_W_L[10].stamp};  // a stray one
  const RoomAccuracy result = compare_rooms(truth, submaps);
  CHECK(result.final_submaps == 3);
  REQUIRE(result.rooms.size() == 2);
  CHECK(result.rooms[0].submaps == 1);
  CHECK(result.rooms[1].submaps == 1);
  CHECK(result.rooms[1].scans < 30);
  CHECK(result.adjusted_rand_index > 0.9);
}

/// A replay's output made by hand: the true mesh moved to M, a program that answers "free" to everything.
class FakeReplay {
 public:
  FakeReplay()
      : root_(fs::temp_directory_path() /
              ("cloister-ground-truth-test-" + std::to_string(getpid()))) {
    fs::remove_all(root_);
    fs::create_directories(mission() / "ground_truth");
    fs::create_directories(out());
    const GroundTruth truth = make_truth();
    const Pose T_M_W = some_pose().inverse();
    std::string true_tum;
    std::string tum;
    std::string stamps;
    for (const StampedPose& pose : truth.T_W_L) {
      Trajectory one{pose.stamp, Duration{1}, {pose.pose}};
      true_tum += format_tum(one);
      one.poses[0] = T_M_W * pose.pose;
      tum += format_tum(one);
      stamps += (stamps.empty() ? "" : ",") + std::to_string(pose.stamp.ns);
    }
    TriangleMesh mesh_M = truth.mesh_W;
    for (Eigen::Vector3f& v : mesh_M.vertices) v = (T_M_W * v.cast<double>()).cast<float>();
    write(mission() / "ground_truth/trajectory.tum", true_tum);
    write(mission() / "ground_truth/rooms.json",
          R"([{"id":0,"name":"first","storey":0,"min":[0,0,0],"max":[4,4,3]},
              {"id":1,"name":"second","storey":0,"min":[4,0,0],"max":[8,4,3]}])");
    write(out() / "trajectory.tum", tum);
    write(out() / "submaps.json", "[{\"id\":3,\"scan_stamps_ns\":[" + stamps + "]}]");
    written_ = write_ply(mission() / "ground_truth/mesh.ply", truth.mesh_W).has_value() &&
               write_ply(out() / "mesh.ply", mesh_M).has_value();
    write(root_ / "cloister",
          "#!/bin/sh\n[ \"$1\" = query ] || exit 2\necho x,y,z,state,log_odds,submap\n"
          "sed 1d \"$3\" | sed 's/$/,free,-1.0,3/'\n");
    fs::permissions(root_ / "cloister", fs::perms::owner_all);
  }
  FakeReplay(const FakeReplay&) = delete;
  FakeReplay& operator=(const FakeReplay&) = delete;
  ~FakeReplay() { fs::remove_all(root_); }

  [[nodiscard]] bool written() const { return written_; }
  [[nodiscard]] fs::path mission() const { return root_ / "mission"; }
  [[nodiscard]] fs::path out() const { return root_ / "out"; }
  [[nodiscard]] fs::path json() const { return root_ / "result.json"; }

  [[nodiscard]] int judge(const std::string& more = "") const {
    const std::string command = std::string(CLOISTER_GROUND_TRUTH_PROGRAM) + " " + mission().string() +
                                " " + out().string() + " --points 2000 --samples 5000 --cloister " +
                                (root_ / "cloister").string() + " --json " + json().string() +
                                more + " > /dev/null 2> /dev/null";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  static void write(const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  }

 private:
  fs::path root_;
  bool written_ = false;
};

TEST_CASE("the tool judges a replay end to end and finds exactly what was planted") {
  const FakeReplay replay;
  REQUIRE(replay.written());
  REQUIRE(replay.judge() == 0);
  std::ifstream stream(replay.json());
  const auto result = nlohmann::json::parse(stream, nullptr, false);
  REQUIRE(result.is_object());
  CHECK(result["trajectory"]["poses"] == 71);
  CHECK(result["trajectory"]["max_m"].get<double>() < 1e-6);
  CHECK(result["states"]["points"] == 2000);
  CHECK(result["states"]["known_free"] == 2000);
  const double right = result["states"]["known_free_right"].get<double>();
  CHECK(right < 0.98);  // the pillar and the slabs were called free too
  CHECK(right > 0.85);
  CHECK(result["mesh"]["within_5cm"] == 1.0);
  CHECK(result["mesh"]["complete_10cm"] == 1.0);
  CHECK(result["rooms"]["final_submaps"] == 1);
  CHECK(result["rooms"]["max_submaps_per_room"] == 1);
  CHECK(std::abs(result["rooms"]["adjusted_rand_index"].get<double>()) < 1e-9);
}

TEST_CASE("the tool refuses what it cannot read with the exit status of its kind") {
  const FakeReplay replay;
  REQUIRE(replay.written());
  CHECK(replay.judge(" --points 0") == 2);
  CHECK(replay.judge(" --bogus") == 2);
  CHECK(replay.judge(" --cloister /no/such/program") == 2);  // given twice
  FakeReplay::write(replay.out() / "submaps.json", "[{\"id\":3}]");
  CHECK(replay.judge() == 3);
  fs::remove(replay.out() / "trajectory.tum");
  CHECK(replay.judge() == 3);
}

}  // namespace
}  // namespace cloister
