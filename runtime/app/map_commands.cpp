#include "runtime/app/map_commands.hpp"

#include <iostream>
#include <string>

#include "firmware_interface/files/csv_file.hpp"
#include "firmware_interface/files/g2o_file.hpp"
#include "firmware_interface/files/text_format.hpp"
#include "firmware_interface/map/map_export.hpp"
#include "firmware_interface/map/map_file.hpp"
#include "firmware_interface/map/map_query.hpp"
#include "firmware_interface/map/states_csv.hpp"
#include "mapping/graph/relative_uncertainty.hpp"

namespace cloister {

Result<void> run_query(const std::filesystem::path& map, const std::filesystem::path& points) {
  const auto loaded = load_map(map);
  if (!loaded) return tl::unexpected(loaded.error());
  const auto points_M = load_points_csv(points);
  if (!points_M) return tl::unexpected(points_M.error());
  return write_states_csv(MapQuery(loaded->view()), *points_M, std::cout);
}

Result<void> run_export(const std::filesystem::path& map, const std::filesystem::path& out, bool cloud) {
  const auto loaded = load_map(map);
  if (!loaded) return tl::unexpected(loaded.error());
  return export_map(loaded->view(), out, {cloud});
}

Result<void> run_uncertainty(const std::filesystem::path& graph, const std::filesystem::path& pairs,
                             double default_information, bool gtsam_default) {
  const auto loaded = load_g2o(graph, {default_information});
  if (!loaded) return tl::unexpected(loaded.error());
  const auto wanted = load_pairs_csv(pairs);
  if (!wanted) return tl::unexpected(wanted.error());
  for (std::size_t k = 0; k < wanted->size(); ++k) {
    for (const NodeId node : {(*wanted)[k].first, (*wanted)[k].second}) {
      if (loaded->find(node) < 0) {
        return fail(ErrorKind::kInput, pairs.string() + ": pair " + std::to_string(k + 1) + " names node " +
                                           std::to_string(node) + ", which " + graph.string() + " does not have");
      }
    }
  }
  auto uncertainty = RelativeUncertainty::build(
      *loaded, gtsam_default ? ResidualJacobian::kGtsamDefault : ResidualJacobian::kExact);
  if (!uncertainty) return fail(ErrorKind::kInput, graph.string() + ": " + uncertainty.error().message);

  std::string text = "i,j";
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) text += ",S" + std::to_string(row) + std::to_string(column);
  }
  text += ",lam1,lam2,lam3\n";
  for (const auto& [i, j] : *wanted) {
    const auto covariance = uncertainty->covariance(i, j);
    if (!covariance) {
      return fail(ErrorKind::kInput, graph.string() + ": no chain of edges joins nodes " + std::to_string(i) +
                                         " and " + std::to_string(j));
    }
    append_number(text, i);
    text += ',';
    append_number(text, j);
    for (int row = 0; row < 6; ++row) {
      for (int column = 0; column < 6; ++column) {
        text += ',';
        append_number(text, (*covariance)(row, column));
      }
    }
    const Eigen::Vector3d variances_m2 = translational_variances_m2(*covariance);
    for (int k = 0; k < 3; ++k) {
      text += ',';
      append_number(text, variances_m2[k]);
    }
    text += '\n';
  }
  std::cout << text << std::flush;
  if (!std::cout) return fail(ErrorKind::kResource, "stdout: cannot write the covariances");
  return {};
}

}  // namespace cloister
