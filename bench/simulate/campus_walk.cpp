#include "bench/simulate/campus_walk.hpp"

#include <algorithm>
#include <cmath>

#include "bench/simulate/path_writer.hpp"

namespace cloister {

namespace {

constexpr double kSensorHeight = 1.2;

/// Parts of the way, each from where the one before ends. T is the tunnel's east end, G the gate of
/// the park.
class CampusWay {
 public:
  explicit CampusWay(RandomStream* random) : random_(random), path_(0.0, random) {}

  void start() { path_.exact(44.5, 61.0); }
  void quad_round(bool reverse) {
    std::vector<Eigen::Vector2d> places = {{45.0, 52.0}, {44.8, 44.0}, {30.0, 43.4},
                                           {14.0, 43.6}, {13.4, 60.0}, {13.8, 78.4},
                                           {29.0, 78.8}, {44.6, 78.2}, {45.0, 70.0}};
    follow(std::move(places), reverse, 3);
    path_.exact(44.5, 61.0);
  }
  void out_by_tunnel() {
    for (const double x : {48.0, 53.5, 59.0}) path_.around(x, 61.0, 0.0, 0.35);
  }
  void in_by_tunnel() {
    for (const double x : {59.0, 53.5, 48.0, 44.5}) path_.around(x, 61.0, 0.0, 0.35);
  }
  void to_gate() {
    for (const double x : {64.0, 70.0, 74.0}) near(x, 61.0);
  }
  void from_gate() {
    for (const double x : {74.0, 70.0, 64.0}) near(x, 61.0);
  }
  void park_round(bool reverse) {
    follow({{74.5, 47.0},
            {76.0, 36.0},
            {88.0, 34.0},
            {101.0, 35.0},
            {116.0, 34.5},
            {130.0, 37.0},
            {130.5, 50.0},
            {128.5, 61.0},
            {130.0, 74.0},
            {128.5, 86.5},
            {114.0, 87.5},
            {100.0, 86.0},
            {87.0, 87.5},
            {76.0, 85.5},
            {74.8, 73.0}},
           reverse, 4);
    near(74.0, 61.0);
  }
  /// From the tunnel along the north street, into the park from the north, to its gate.
  void north_round() {
    follow({{64.0, 61.0},
            {64.5, 76.0},
            {63.5, 98.5},
            {40.0, 98.0},
            {12.0, 98.8},
            {11.0, 97.2},
            {40.0, 99.5},
            {64.0, 99.0},
            {90.0, 98.0},
            {110.0, 98.5},
            {110.0, 92.0},
            {108.5, 80.0},
            {102.0, 61.0},
            {88.0, 62.0},
            {74.0, 61.0}},
           false, 5);
  }
  void south_round() {
    follow({{64.0, 61.0},
            {63.5, 45.0},
            {64.0, 23.0},
            {40.0, 23.5},
            {14.0, 22.5},
            {13.0, 24.0},
            {40.0, 22.0},
            {64.0, 22.4},
            {84.0, 23.0},
            {101.0, 23.0},
            {101.0, 30.0},
            {99.0, 45.0},
            {102.0, 61.0},
            {88.0, 60.0},
            {74.0, 61.0}},
           false, 5);
  }
  [[nodiscard]] std::vector<Waypoint> take() { return path_.take(); }

 private:
  static constexpr double kSpread = 0.45;

  void near(double x, double y, double pause_s = 0.0) { path_.around(x, y, pause_s, kSpread); }

  /// Walks from place to place and stops at `pauses` of them, to look around or to let others pass.
  void follow(std::vector<Eigen::Vector2d> places, bool reverse, std::size_t pauses) {
    if (reverse) std::reverse(places.begin(), places.end());
    const std::size_t every = places.size() / pauses;
    const std::size_t first = random_->below(every);
    for (std::size_t k = 0; k < places.size(); ++k) {
      const bool stops = k % every == first && k / every < pauses;
      near(places[k].x(), places[k].y(), stops ? random_->uniform(5.0, 11.5) : 0.0);
    }
  }

  RandomStream* random_;
  PathWriter path_;
};

/// Lays a plan view of a path on the ground.
std::vector<Waypoint> drape(const std::vector<Waypoint>& plan, const HeightField& ground) {
  constexpr double kEvery_m = 1.0;
  std::vector<Waypoint> path;
  const auto add = [&](const Eigen::Vector3d& p, double pause_s) {
    path.push_back({{p.x(), p.y(), ground.at(p.x(), p.y()) + kSensorHeight}, pause_s});
  };
  for (std::size_t k = 0; k + 1 < plan.size(); ++k) {
    const Eigen::Vector3d step = plan[k + 1].position_W - plan[k].position_W;
    const int count = std::max(1, static_cast<int>(std::lround(step.norm() / kEvery_m)));
    for (int n = 0; n < count; ++n)
      add(plan[k].position_W + step * n / count, n == 0 ? plan[k].pause_s : 0.0);
  }
  add(plan.back().position_W, 0.0);
  return path;
}

}  // namespace

std::vector<Waypoint> walk_campus(const HeightField& ground, RandomStream* random) {
  CampusWay way(random);
  way.start();
  for (int round = 0; round < 5; ++round) {
    const bool reverse = round % 2 == 1;
    way.quad_round(reverse);
    way.out_by_tunnel();
    if (round == 1) {
      way.north_round();
    } else if (round == 3) {
      way.south_round();
    } else {
      way.to_gate();
      way.park_round(round == 4);
    }
    way.from_gate();
    way.in_by_tunnel();
  }
  way.quad_round(true);
  return drape(way.take(), ground);
}

}  // namespace cloister
