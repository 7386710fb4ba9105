#include "firmware_interface/output/submaps_json.hpp"

#include <nlohmann/json.hpp>

namespace cloister {
namespace {

using Json = nlohmann::ordered_json;

Json point_json(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

Json pose_json(const Pose& T_A_B) {
  Eigen::Quaterniond q(T_A_B.linear());
  if (q.w() < 0) q.coeffs() *= -1.0;
  const auto t = T_A_B.translation();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

Json submap_json(const SubmapRecord& submap) {
  Json stamps = Json::array();
  for (const SensorTime stamp : submap.scan_stamps) stamps.push_back(stamp.ns);
  Json json;
  json["id"] = submap.id;
  json["merged_from"] = submap.merged_from;
  json["root_node"] = submap.root;
  json["T_M_S"] = pose_json(submap.T_M_S);
  json["aabb_M"] = {{"min", point_json(submap.aabb_min_M)}, {"max", point_json(submap.aabb_max_M)}};
  json["nodes"] = submap.nodes;
  json["scan_stamps_ns"] = std::move(stamps);
  json["blocks"] = submap.blocks;
  json["bytes"] = submap.bytes;
  json["observed_m3"] = submap.observed_m3;
  return json;
}

}  // namespace

std::string submaps_json(const std::vector<SubmapRecord>& submaps) {
  std::string text = "[";
  for (const SubmapRecord& submap : submaps) {
    text += text.size() == 1 ? "\n" : ",\n";
    text += submap_json(submap).dump();
  }
  text += "\n]\n";
  return text;
}

}  // namespace cloister
