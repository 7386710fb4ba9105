#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <CLI/CLI.hpp>

#include "bench/integration/bar_plot.hpp"
#include "bench/support/program.hpp"

namespace cloister {
namespace {

Result<void> plot(const std::filesystem::path& csv, const std::filesystem::path& svg) {
  std::ifstream in(csv);
  std::stringstream text;
  text << in.rdbuf();
  if (!in) return fail(ErrorKind::kInput, csv.string() + ": cannot be read: run the bench first");
  const auto bars = read_bars(text.str(), csv.string());
  if (!bars) return tl::unexpected(bars.error());
  if (bars->empty())
    return fail(ErrorKind::kInput, csv.string() + ": no rows: run the bench first");
  std::ofstream out(svg);
  out << bar_plot_svg(*bars);
  out.close();
  if (!out) return fail(ErrorKind::kResource, svg.string() + ": cannot be written: check the path");
  return {};
}

int run(int argc, char** argv) {
  std::filesystem::path csv, svg;
  CLI::App app("Draws the results of cloister-bench-integration as bars.", "cloister-bench-plot");
  app.add_option("RESULTS", csv, "the CSV that the bench wrote")->required();
  app.add_option("--out", svg, "the SVG to write")->required();
  return run_program(app, argc, argv, [&]() -> Result<int> {
    const auto done = plot(csv, svg);
    if (!done) return tl::unexpected(done.error());
    return 0;
  });
}

}  // namespace
}  // namespace cloister

int main(int argc, char** argv) { return cloister::run(argc, argv); }
