#include <doctest/doctest.h>

#include "bench/integration/bar_plot.hpp"
#include "bench/integration/bench_result.hpp"

namespace cloister {
namespace {

TEST_CASE("percentiles are those of the nearest rank") {
  std::vector<double> values;
  for (int i = 1000; i > 0; --i) values.push_back(i);
  CHECK(percentile(values, 0.5) == 500);
  CHECK(percentile(values, 0.99) == 990);
  CHECK(percentile(values, 0.999) == 999);
  CHECK(percentile(values, 1) == 1000);
  CHECK(percentile({3}, 0.5) == 3);
  CHECK(percentile({}, 0.5) == 0);
}

TEST_CASE("every row has the same columns, whatever was measured") {
  BenchResult full;
  full.library = "cloister";
  full.costs.push_back({0, 0, {1'500'000, 3000, 0, 0}, 10});
  full.truth.emplace();
  full.times_faster = 10;
  const auto a = cells_of({}, full);
  const auto b = cells_of({}, {});
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i].name == b[i].name);
}

TEST_CASE("a table says which cycles it has") {
  BenchContext context;
  context.cycle_kind = CycleKind::kReference;
  BenchResult counted;
  counted.costs.push_back({0, 0, {1'000'000, 3'000'000, 0, 0}, 10});
  BenchResult uncounted;
  uncounted.costs.push_back({0, 0, {1'000'000, std::nullopt, 0, 0}, 10});
  const auto value_of = [&](const BenchResult& result, const std::string& name) {
    for (const Cell& cell : cells_of(context, result)) {
      if (cell.name == name) return cell.value;
    }
    return std::string("no such column");
  };
  CHECK(value_of(counted, "cycles_of") == "reference");
  CHECK(value_of(counted, "cycles_per_touched_voxel") == "585.94");
  CHECK(value_of(uncounted, "cycles_of").empty());
  CHECK(value_of(uncounted, "cycles_per_scan").empty());
}

TEST_CASE("bars are read by the names of their columns, and the last of a kind counts") {
  const auto bars = read_bars(
      "machine,p999_ms,median_ms,scans,mission,library\n"
      "m,3,2,10,house,cloister\nm,400,300,5,house,octomap\nm,2,1,10,house,cloister\n",
      "r.csv");
  REQUIRE(bars.has_value());
  REQUIRE(bars->size() == 2);
  CHECK((*bars)[0].library == "cloister");
  CHECK((*bars)[0].median_ms == 1);
  CHECK((*bars)[1].p999_ms == 400);
}

TEST_CASE("a results file that cannot be drawn is refused with its line") {
  const auto no_column = read_bars("mission,library\n", "r.csv");
  REQUIRE_FALSE(no_column.has_value());
  CHECK(no_column.error().message.starts_with("r.csv:1:"));
  for (const char* row : {"h,c,m,1,0,1", "h,c,m,1,x,1", "h,c,m,1,1"}) {
    CAPTURE(row);
    const auto refused =
        read_bars(std::string("mission,library,machine,scans,median_ms,p999_ms\n") + row, "r.csv");
    REQUIRE_FALSE(refused.has_value());
    CHECK(refused.error().message.starts_with("r.csv:2:"));
  }
}

TEST_CASE("a plot has a bar for each row and escapes names") {
  const std::string svg =
      bar_plot_svg({{"a<b", "cloister", "m", 10, 2, 3}, {"a<b", "octomap", "m", 5, 300, 400}});
  CHECK(svg.starts_with("<svg "));
  CHECK(svg.find("a&lt;b") != std::string::npos);
  CHECK(svg.find("a<b") == std::string::npos);
  CHECK(svg.find("300 ms (5 scans)") != std::string::npos);
  CHECK(bar_plot_svg({}).empty());
}

}  // namespace
}  // namespace cloister
