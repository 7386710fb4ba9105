#include "bench/support/program.hpp"

#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

namespace cloister {

int run_program(CLI::App& app, int argc, char** argv, const std::function<Result<int>()>& work) {
  const char* name = app.get_name().c_str();
  try {
    app.parse(argc, argv);
    const Result<int> status = work();
    if (status) return *status;
    std::fprintf(stderr, "%s: %s\n", name, status.error().message.c_str());
    return static_cast<int>(status.error().kind);
  } catch (const CLI::CallForHelp&) {
    std::fputs(app.help().c_str(), stdout);
    return 0;
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "%s: %s: see %s --help\n", name, error.what(), name);
    return static_cast<int>(ErrorKind::kUsage);
  } catch (const std::exception& error) {  // nothing of ours throws
    std::fprintf(stderr, "%s: %s: free some memory or disk and try again\n", name, error.what());
    return static_cast<int>(ErrorKind::kResource);
  }
}

}  // namespace cloister
