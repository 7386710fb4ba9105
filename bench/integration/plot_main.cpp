#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <CLI/CLI.hpp>

#include "bench/integration/bar_plot.hpp"

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
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    std::fputs(app.help().c_str(), stdout);
    return 0;
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "cloister-bench-plot: %s: see --help\n", error.what());
    return static_cast<int>(ErrorKind::kUsage);
  }
  const auto done = plot(csv, svg);
  if (done) return 0;
  std::fprintf(stderr, "cloister-bench-plot: %s\n", done.error().message.c_str());
  return static_cast<int>(done.error().kind);
}

}  // namespace
}  // namespace cloister

int main(int argc, char** argv) {
  try {
    return cloister::run(argc, argv);
  } catch (const std::exception& error) {  // memory: nothing else throws
    std::fprintf(stderr, "cloister-bench-plot: %s: free some memory and try again\n", error.what());
    return static_cast<int>(cloister::ErrorKind::kResource);
  }
}
