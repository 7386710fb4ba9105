#include "bench/experiments/pair_doubt.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include "bench/support/child_program.hpp"
#include "bench/simulate/number_text.hpp"

namespace cloister {

namespace fs = std::filesystem;

Result<std::vector<RootPair>> read_root_pairs(const nlohmann::json& final_map) {
  std::vector<RootPair> pairs;
  const bool has_list =
      final_map.is_object() && final_map.contains("pairs") && final_map["pairs"].is_array();
  if (!has_list) return fail(ErrorKind::kInput, "the final map's description lists no pairs");
  for (const auto& entry : final_map["pairs"]) {
    const bool is_whole = entry.is_object() && entry.contains("root_a") &&
                          entry["root_a"].is_number_integer() && entry.contains("root_b") &&
                          entry["root_b"].is_number_integer();
    if (!is_whole) {
      return fail(ErrorKind::kInput, "pair " + std::to_string(pairs.size()) +
                                         " of the final map's description has no roots");
    }
    pairs.emplace_back(entry["root_a"].get<std::int64_t>(), entry["root_b"].get<std::int64_t>());
  }
  return pairs;
}

Result<std::vector<double>> parse_doubts_m(std::string_view csv, std::string_view file_name) {
  std::vector<double> doubts_m;
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < csv.size();) {
    const std::size_t end = std::min(csv.find('\n', begin), csv.size());
    const auto words = split_words(csv.substr(begin, end - begin), ",");
    begin = end + 1;
    if (++number == 1) continue;
    double variance_m2 = 0.0;
    if (words.size() != 41 || !parse_number(words.back(), &variance_m2)) {
      return fail(ErrorKind::kInput, std::string(file_name) + ":" + std::to_string(number) +
                                         ": needs 41 cells, the last one a variance");
    }
    doubts_m.push_back(std::sqrt(std::max(0.0, variance_m2)));
  }
  return doubts_m;
}

Result<std::vector<double>> ask_doubts_m(const fs::path& cloister, const fs::path& pose_graphs,
                                         const fs::path& scratch,
                                         const std::vector<RootPair>& pairs) {
  constexpr double kNoIdea = std::numeric_limits<double>::infinity();
  std::vector<double> doubts_m(pairs.size(), kNoIdea);
  std::vector<std::size_t> asked;
  std::string question = "i,j\n";
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [a, b] = pairs[k];
    if (a < 0 || b < 0) continue;
    if (a == b) {
      doubts_m[k] = 0.0;
      continue;
    }
    asked.push_back(k);
    question += std::to_string(a) + "," + std::to_string(b) + "\n";
  }
  if (asked.empty()) return doubts_m;

  fs::path graph;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(pose_graphs, error)) {
    if (entry.path().extension() == ".g2o") graph = std::max(graph, entry.path());
  }
  std::ofstream(scratch / "pairs.csv") << question;
  const auto done = run_program(
      {cloister.string(), "uncertainty", graph.string(), (scratch / "pairs.csv").string()},
      scratch / "doubts.csv", scratch / "doubts.log");
  if (!done) return tl::unexpected(done.error());
  std::ifstream stream(scratch / "doubts.csv", std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  const auto answers_m = parse_doubts_m(text, (scratch / "doubts.csv").string());
  if (!answers_m) return tl::unexpected(answers_m.error());
  if (answers_m->size() != asked.size()) {
    return fail(ErrorKind::kInput, (scratch / "doubts.csv").string() + ": answers " +
                                       std::to_string(answers_m->size()) + " of " +
                                       std::to_string(asked.size()) + " pairs: run it again");
  }
  for (std::size_t n = 0; n < asked.size(); ++n) doubts_m[asked[n]] = (*answers_m)[n];
  return doubts_m;
}

}  // namespace cloister
