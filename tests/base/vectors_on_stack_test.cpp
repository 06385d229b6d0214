// Vectors that a function saves on its stack, wherever that begins: on Windows GCC does not align it as they
// need, which cmake/windows.cmake makes up for.
#include <gtest/gtest.h>

#if defined(__x86_64__)
#include <immintrin.h>

#include <array>
#include <iterator>
#include <numeric>
#include <thread>

namespace foldproof {
namespace {

constexpr std::size_t kVectors = 40;  // more than there are registers

[[gnu::noinline, gnu::target("avx2")]] __m256d add(__m256d a, __m256d b) { return _mm256_add_pd(a, b); }
[[gnu::noinline, gnu::target("avx512f")]] __m512d add(__m512d a, __m512d b) { return _mm512_add_pd(a, b); }

// What a call takes and returns passes through the caller's stack on Windows, and all that lives longer is
// saved there.
[[gnu::noinline, gnu::target("avx2")]] double sum_of_256_bits(const double* x) {
  __m256d saved[kVectors];
  for (std::size_t i = 0; i < kVectors; ++i) saved[i] = _mm256_loadu_pd(x + 8 * i);
  __m256d sum = _mm256_setzero_pd();
  for (const __m256d& vector : saved) sum = add(add(sum, vector), _mm256_setzero_pd());
  double lanes[4];
  _mm256_storeu_pd(lanes, sum);
  return std::accumulate(std::begin(lanes), std::end(lanes), 0.0);
}

[[gnu::noinline, gnu::target("avx512f")]] double sum_of_512_bits(const double* x) {
  __m512d saved[kVectors];
  for (std::size_t i = 0; i < kVectors; ++i) saved[i] = _mm512_loadu_pd(x + 8 * i);
  __m512d sum = _mm512_setzero_pd();
  for (const __m512d& vector : saved) sum = add(add(sum, vector), _mm512_setzero_pd());
  double lanes[8];
  _mm512_storeu_pd(lanes, sum);
  return std::accumulate(std::begin(lanes), std::end(lanes), 0.0);
}

/// Calls a function after taking some of the stack.
[[gnu::noinline]] double sum_below(double (*sum)(const double*), const double* x, std::size_t bytes) {
  auto* taken = static_cast<volatile char*>(__builtin_alloca(bytes));
  taken[0] = 1;
  const double result = sum(x);
  taken[0] = 2;
  return result;
}

void expect_sums(double (*sum)(const double*), std::size_t lanes) {
  std::array<double, 8 * kVectors> x;
  std::iota(x.begin(), x.end(), 1.0);
  double expected = 0;
  for (std::size_t i = 0; i < x.size(); ++i) expected += i % 8 < lanes ? x[i] : 0;
  for (std::size_t bytes = 16; bytes <= 256; bytes += 16)
    EXPECT_EQ(sum_below(sum, x.data(), bytes), expected);
  std::thread([&] { EXPECT_EQ(sum_below(sum, x.data(), 16), expected); }).join();
}

#if defined(_WIN32)
// Debian's compiler writes no moves that need an alignment, so the other tests do not need the assembler's
// option. This one traps without it.
TEST(VectorsOnStack, AssemblerReplacesAlignedMoves) {
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "no AVX2";
  using Vector = float[8];
  alignas(16) float place[12] = {};
  for (float* vector : {place, place + 4}) {  // one of them is not aligned
    asm volatile("vmovaps %0, %%ymm0\n\tvmovaps %%ymm0, %0"
                 : "+m"(*reinterpret_cast<Vector*>(vector))
                 :
                 : "xmm0");
    EXPECT_EQ(vector[7], 0);
  }
}
#endif

TEST(VectorsOnStack, Of256Bits) {
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "no AVX2";
  expect_sums(sum_of_256_bits, 4);
}

TEST(VectorsOnStack, Of512Bits) {
  if (!__builtin_cpu_supports("avx512f")) GTEST_SKIP() << "no AVX-512";
  expect_sums(sum_of_512_bits, 8);
}

}  // namespace
}  // namespace foldproof
#endif
