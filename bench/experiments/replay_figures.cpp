#include "bench/experiments/replay_figures.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <string>

#include "bench/experiments/json_file.hpp"

namespace cloister {

namespace {

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find(',', at), line.size());
    cells.push_back(line.substr(at, end - at));
    at = end + 1;
  }
  return cells;
}

bool parse_whole(std::string_view cell, std::int64_t* value) {
  const auto result = std::from_chars(cell.data(), cell.data() + cell.size(), *value);
  return result.ec == std::errc{} && result.ptr == cell.data() + cell.size();
}

}  // namespace

Result<std::vector<MapSize>> parse_timeline(std::string_view csv, std::string_view file_name) {
  std::vector<MapSize> growth;
  std::ptrdiff_t stamp_at = -1, submaps_at = -1, bytes_at = -1;
  std::size_t number = 0;
  const auto refuse = [&](const std::string& what) {
    return fail(ErrorKind::kInput,
                std::string(file_name) + ":" + std::to_string(number) + ": " + what);
  };
  for (std::size_t begin = 0; begin < csv.size();) {
    const std::size_t end = std::min(csv.find('\n', begin), csv.size());
    const auto cells = cells_of(csv.substr(begin, end - begin));
    begin = end + 1;
    if (++number == 1) {
      const auto column = [&](std::string_view name) {
        const auto at = std::find(cells.begin(), cells.end(), name);
        return at == cells.end() ? -1 : at - cells.begin();
      };
      stamp_at = column("stamp_ns");
      submaps_at = column("submaps");
      bytes_at = column("map_bytes");
      if (std::min({stamp_at, submaps_at, bytes_at}) < 0)
        return refuse("needs the columns stamp_ns, submaps and map_bytes");
      continue;
    }
    if (std::max({stamp_at, submaps_at, bytes_at}) >= std::ssize(cells))
      return refuse("has too few cells");
    MapSize size;
    const auto cell = [&](std::ptrdiff_t at) { return cells[static_cast<std::size_t>(at)]; };
    if (!parse_whole(cell(stamp_at), &size.stamp.ns) ||
        !parse_whole(cell(submaps_at), &size.submaps) || !parse_whole(cell(bytes_at), &size.bytes))
      return refuse("stamp_ns, submaps and map_bytes must be whole numbers");
    if (!growth.empty() && size.stamp <= growth.back().stamp)
      return refuse("its stamp does not rise");
    growth.push_back(size);
  }
  if (number == 0) return refuse("is empty: write it again");
  return growth;
}

std::int64_t map_bytes_at(const std::vector<MapSize>& growth, SensorTime stamp) {
  const auto after =
      std::upper_bound(growth.begin(), growth.end(), stamp,
                       [](SensorTime t, const MapSize& size) { return t < size.stamp; });
  return after == growth.begin() ? 0 : std::prev(after)->bytes;
}

double growth_in_last_third(const std::vector<MapSize>& growth) {
  if (growth.empty()) return 0.0;
  const Duration length = growth.back().stamp - growth.front().stamp;
  const auto before =
      map_bytes_at(growth, growth.front().stamp + Duration{length.ns - length.ns / 3});
  const auto end = static_cast<double>(growth.back().bytes);
  return before > 0 ? end / static_cast<double>(before) - 1.0 : 0.0;
}

Result<ReplayFigures> read_replay(const std::filesystem::path& out) {
  auto summary = JsonFile::open(out / "summary.json");
  if (!summary) return tl::unexpected(summary.error());
  const auto count = [&](const char* at) { return summary->number<std::int64_t>(at); };
  const auto real = [&](const char* at) { return summary->number<double>(at); };
  ReplayFigures figures;
  figures.scans = count("/scans/integrated");
  figures.duration_s = real("/duration_s");
  figures.travel_m = real("/travel_m");
  figures.submaps_spawned = count("/submaps/spawned");
  figures.submaps_peak = count("/submaps/peak");
  figures.submaps_final = count("/submaps/final");
  figures.map_bytes_peak = count("/memory/map_bytes_peak");
  figures.map_bytes_final = count("/memory/map_bytes_final");
  figures.integrate_p50_ms = real("/timing_ms/integrate/p50");
  figures.integrate_p99_ms = real("/timing_ms/integrate/p99");
  figures.latency_p50_ms = real("/timing_ms/latency/p50");
  figures.latency_p99_ms = real("/timing_ms/latency/p99");
  figures.overlap_p99_ms = real("/timing_ms/overlap/p99");
  figures.cpu = {real("/cpu_s/decode"),  real("/cpu_s/spawn_check"), real("/cpu_s/integration"),
                 real("/cpu_s/overlap"), real("/cpu_s/uncertainty"), real("/cpu_s/fusion"),
                 real("/cpu_s/total")};
  figures.max_sigma_m = real("/config/fusion/max_sigma_m");
  if (const auto whole = summary->is_whole(); !whole) return tl::unexpected(whole.error());

  const std::filesystem::path file = out / "timeline.csv";
  std::ifstream stream(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  auto growth = parse_timeline(text, file.string());
  if (!growth) return tl::unexpected(growth.error());
  figures.growth = std::move(*growth);
  return figures;
}

}  // namespace cloister
