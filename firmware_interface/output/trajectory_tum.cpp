#include "firmware_interface/output/trajectory_tum.hpp"

#include "firmware_interface/files/text_format.hpp"

namespace cloister {

std::string trajectory_tum(const std::vector<std::pair<SensorTime, Pose>>& path_M) {
  std::string text =
      "# stamp_s x y z qx qy qz qw: sensor in M at every integrated scan, by the last graph\n";
  for (const auto& [stamp, T_M_L] : path_M) {
    append_stamp(text, stamp);
    const auto t_M_L = T_M_L.translation();
    const Eigen::Quaterniond q_M_L(T_M_L.linear());
    for (const double value :
         {t_M_L.x(), t_M_L.y(), t_M_L.z(), q_M_L.x(), q_M_L.y(), q_M_L.z(), q_M_L.w()}) {
      text += ' ';
      append_number(text, value);
    }
    text += '\n';
  }
  return text;
}

}  // namespace cloister
