#include "runtime/app/stop_signal.hpp"

#include <csignal>

namespace cloister {
namespace {

volatile std::sig_atomic_t g_signal = 0;

}  // namespace

StopSignal::StopSignal() {
  g_signal = 0;
  struct sigaction action {};
  action.sa_handler = [](int number) { g_signal = number; };
  // Without SA_RESTART: a wait for packets ends at once.
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

StopSignal::~StopSignal() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

int StopSignal::number() { return g_signal; }

}  // namespace cloister
