#include "bench/simulate/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "bench/simulate/number_text.hpp"

namespace cloister {

namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

/// Seconds with decimals, exact to the nanosecond: a double holds Unix time only to about 0.2
/// microseconds.
bool parse_stamp(std::string_view word, SensorTime* stamp) {
  std::int64_t seconds = 0;
  const auto whole = std::from_chars(word.data(), word.data() + word.size(), seconds);
  if (whole.ec != std::errc{} || seconds < 0) return false;
  word.remove_prefix(static_cast<std::size_t>(whole.ptr - word.data()));
  double fraction = 0.0;
  if (!word.empty()) {
    if (word.front() != '.' || !parse_number(std::string("0").append(word), &fraction))
      return false;
  }
  stamp->ns = seconds * kNsPerSecond + std::llround(fraction * 1e9);
  return true;
}

}  // namespace

Pose Trajectory::at(SensorTime stamp) const {
  const std::int64_t offset = std::clamp<std::int64_t>(stamp.ns - start.ns, 0, end().ns - start.ns);
  const auto k = std::min(static_cast<std::size_t>(offset / step.ns), poses.size() - 1);
  const std::int64_t rest = offset - static_cast<std::int64_t>(k) * step.ns;
  if (rest == 0) return poses[k];
  return interpolate(poses[k], poses[k + 1],
                     static_cast<double>(rest) / static_cast<double>(step.ns));
}

void Trajectory::cut_after(SensorTime stamp) {
  const auto keep =
      static_cast<std::size_t>(std::max<std::int64_t>(0, (stamp.ns - start.ns) / step.ns)) + 1;
  if (keep < poses.size()) poses.resize(keep);
}

std::string format_seconds(SensorTime stamp) {
  char buffer[40];
  std::snprintf(buffer, sizeof(buffer), "%lld.%09lld",
                static_cast<long long>(stamp.ns / kNsPerSecond),
                static_cast<long long>(stamp.ns % kNsPerSecond));
  return buffer;
}

std::string format_tum(const Trajectory& trajectory) {
  std::string text;
  text.reserve(trajectory.poses.size() * 150);
  for (std::size_t k = 0; k < trajectory.poses.size(); ++k) {
    const Pose& pose = trajectory.poses[k];
    const Eigen::Quaterniond q(pose.linear());
    text += format_seconds(trajectory.stamp(k));
    for (const double value : {pose.translation().x(), pose.translation().y(),
                               pose.translation().z(), q.x(), q.y(), q.z(), q.w()}) {
      text += ' ';
      append_number(value, &text);
    }
    text += '\n';
  }
  return text;
}

Result<std::vector<StampedPose>> read_tum(const std::filesystem::path& path) {
  std::ifstream stream(path);
  if (!stream) return fail(ErrorKind::kInput, path.string() + ": cannot be opened: check the path");
  std::vector<StampedPose> poses;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const auto words = split_words(line);
    if (words.empty()) continue;
    const auto bad = [&](const std::string& what) {
      return fail(ErrorKind::kInput, path.string() + ":" + std::to_string(number) + ": " + what);
    };
    if (words.size() != 8) return bad("a pose is eight numbers: t x y z qx qy qz qw");
    StampedPose pose;
    double v[7];
    if (!parse_stamp(words[0], &pose.stamp)) return bad("the stamp is not a number of seconds");
    for (int k = 0; k < 7; ++k) {
      if (!parse_number(words[static_cast<std::size_t>(k) + 1], &v[k]) || !std::isfinite(v[k])) {
        return bad("a pose holds a word that is not a finite number");
      }
    }
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (std::abs(q.norm() - 1.0) > 1e-2) return bad("the quaternion is not of unit length");
    pose.pose = make_pose({v[0], v[1], v[2]}, q);
    if (!poses.empty() && pose.stamp <= poses.back().stamp) return bad("the stamps must rise");
    poses.push_back(pose);
  }
  if (poses.empty())
    return fail(ErrorKind::kInput, path.string() + ": holds no pose: give at least one line");
  return poses;
}

Pose pose_at(const std::vector<StampedPose>& poses, SensorTime stamp) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), stamp,
                       [](const StampedPose& p, SensorTime s) { return p.stamp < s; });
  if (after == poses.begin()) return poses.front().pose;
  if (after == poses.end()) return poses.back().pose;
  const StampedPose& before = *(after - 1);
  const double fraction =
      (stamp - before.stamp).seconds() / (after->stamp - before.stamp).seconds();
  return interpolate(before.pose, after->pose, fraction);
}

}  // namespace cloister
