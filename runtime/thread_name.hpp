#pragma once

#include <pthread.h>

namespace cloister {

/// Names the calling thread for top, debuggers and /proc: 15 characters at most.
inline void name_this_thread(const char* name) { (void)pthread_setname_np(pthread_self(), name); }

}  // namespace cloister
