#pragma once

#include <ostream>
#include <span>
#include <streambuf>

#include "firmware_interface/files/atomic_file.hpp"

namespace cloister {

/// Lets libraries that write to a std::ostream write to an AtomicFile. Cannot seek. A failure sets
/// the stream's bad bit and stays with the file until its commit.
class AtomicOstream : public std::ostream {
 public:
  explicit AtomicOstream(AtomicFile& file) : std::ostream(nullptr), buffer_(file) {
    rdbuf(&buffer_);
  }

 private:
  class Buffer : public std::streambuf {
   public:
    explicit Buffer(AtomicFile& file) : file_(file) {}

   private:
    std::streamsize xsputn(const char* bytes, std::streamsize size) override {
      const auto count = static_cast<std::size_t>(size);
      return file_.write(std::as_bytes(std::span(bytes, count))) ? size : 0;
    }
    int_type overflow(int_type c) override {
      if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
      const char byte = traits_type::to_char_type(c);
      return xsputn(&byte, 1) == 1 ? c : traits_type::eof();
    }

    AtomicFile& file_;
  };
  Buffer buffer_;
};

}  // namespace cloister
