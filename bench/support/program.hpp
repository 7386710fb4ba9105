#pragma once

#include <functional>

#include "mapping/core/result.hpp"

namespace CLI {
class App;
}

namespace cloister {

/// Reads the command line that `app` declares, answers --help, and runs a program's work. What goes wrong is one line on
/// stderr, behind the app's name; exceptions are taken for a lack of memory or disk.
/// @return the exit status: what `work` gives, or its error's kind
int run_program(CLI::App& app, int argc, char** argv, const std::function<Result<int>()>& work);

}  // namespace cloister
