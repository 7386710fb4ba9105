#pragma once

namespace cloister {

/// Limits the vectors that the library's kernels use to a number of bits: 0 = whatever the processor has, 512, 256, 128,
/// or less for none at all. Every setting gives the same map, bit for bit; narrower vectors can be the better ones on a
/// processor that lowers its clock for wide ones.
/// Threads: before any other thread uses the library.
void limit_vector_bits(int bits);

}  // namespace cloister
