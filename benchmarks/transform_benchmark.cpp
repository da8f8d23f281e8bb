// Measures tensor_transform's kernels against a plain loop compiled with g++ -O2 without vectors,
// and against the fastest pass that reads and writes the same bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <benchmark/benchmark.h>

#include <hwy/cache_control.h>

#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "core/transform/transform.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "transform_benchmark.cpp"
#include <hwy/foreach_target.h>  // compiles the kernels of this file once per CPU target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The minimum work of any u8 -> f32 conversion. Streamed: bypasses the caches.
template <bool kStreamed>
HWY_INLINE void pass(const uint8_t* in, float* out, size_t count) {
  const hn::ScalableTag<float> df;
  const hn::Rebind<int32_t, decltype(df)> di;
  const hn::Rebind<uint8_t, decltype(df)> du;
  const size_t lanes = hn::Lanes(df);
  for (size_t i = 0; i + lanes <= count; i += lanes) {
    const auto v = hn::ConvertTo(df, hn::PromoteTo(di, hn::LoadU(du, in + i)));
    if constexpr (kStreamed)
      hn::Stream(v, df, out + i);
    else
      hn::StoreU(v, df, out + i);
  }
}
void Pass(const uint8_t* in, float* out, size_t count) {
  pass<false>(in, out, count);
}
void StreamedPass(const uint8_t* in, float* out, size_t count) {
  pass<true>(in, out, count);
  hwy::FlushStream();
}

}  // namespace weir::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir {
namespace {

HWY_EXPORT(Pass);
HWY_EXPORT(StreamedPass);

using transform::Mode;

// Memory aligned to a cache line, similar to buffers of GStreamer's pools.
struct Memory {
  explicit Memory(size_t size) : store(size + 64, std::byte{7}) {
    void* at = store.data();
    size_t room = store.size();
    std::align(64, size, at, room);
    bytes = std::span(static_cast<std::byte*>(at), size);
  }
  std::vector<std::byte> store;
  std::span<std::byte> bytes;
};

size_t elements(const benchmark::State& state) {
  return static_cast<size_t>(state.range(0)) * static_cast<size_t>(state.range(1)) * 3;
}

template <class F>
void run_pass(benchmark::State& state, F&& f) {
  Memory in(elements(state)), out(elements(state) * 4);
  for (auto _ : state) {
    f(reinterpret_cast<const uint8_t*>(in.bytes.data()), reinterpret_cast<float*>(out.bytes.data()),
      elements(state));
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(elements(state)));
}

#if defined(__GNUC__) && !defined(__clang__)
#define WEIR_PLAIN_O2 __attribute__((noinline, optimize("O2", "no-tree-vectorize")))
#else
#define WEIR_PLAIN_O2 __attribute__((noinline))
#endif

WEIR_PLAIN_O2 void plain_loop(const uint8_t* in, float* out, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    float x = in[i];
    x += -127.5f;
    x /= 127.5f;
    out[i] = x;
  }
}

void floor_plain_loop(benchmark::State& state) {
  run_pass(state, plain_loop);
}
void floor_pass(benchmark::State& state) {
  run_pass(state, [](auto... a) { HWY_DYNAMIC_DISPATCH(Pass)(a...); });
}
void floor_streamed_pass(benchmark::State& state) {
  run_pass(state, [](auto... a) { HWY_DYNAMIC_DISPATCH(StreamedPass)(a...); });
}

// Noise, because some kernels branch on values.
void fill(std::span<std::byte> bytes, ElementType type) {
  std::minstd_rand random(1);
  for (size_t i = 0; i + element_size(type) <= bytes.size(); i += element_size(type)) {
    const uint32_t value = random() >> 8 & 255U;
    const auto real = static_cast<float>(value);
    if (type == ElementType::Float32)
      std::memcpy(bytes.data() + i, &real, sizeof(real));
    else
      bytes[i] = static_cast<std::byte>(value);
  }
}

void run_plan(benchmark::State& state, Mode mode, const std::string& option, const TensorSpec& spec,
              bool accelerate = true) {
  const auto operation = transform::parse(mode, option);
  const auto plan = transform::plan(*operation, spec, accelerate);
  Memory in(*plan->input().bytes()), out(*plan->output().bytes());
  fill(in.bytes, spec.type);
  for (auto _ : state) {
    plan->apply(in.bytes, out.bytes);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(*spec.shape.count()));
}

TensorSpec picture(const benchmark::State& state, ElementType type) {
  return {
      type, {3, static_cast<uint32_t>(state.range(0)), static_cast<uint32_t>(state.range(1))}, ""};
}

TensorSpec planes(const benchmark::State& state, ElementType type) {
  return {
      type, {static_cast<uint32_t>(state.range(0)), static_cast<uint32_t>(state.range(1)), 3}, ""};
}

void arithmetic(benchmark::State& state, const std::string& option, ElementType type) {
  run_plan(state, Mode::Arithmetic, option, picture(state, type));
}

void arithmetic_plain_path(benchmark::State& state) {
  run_plan(state, Mode::Arithmetic, "typecast:float32,add:-127.5,div:127.5",
           picture(state, ElementType::UInt8), false);
}

void typecast(benchmark::State& state, const std::string& option, ElementType type) {
  run_plan(state, Mode::Typecast, option, picture(state, type));
}

void to_planes(benchmark::State& state, ElementType type) {
  run_plan(state, Mode::Transpose, "1:2:0:3", picture(state, type));
}

void to_pixels(benchmark::State& state, ElementType type) {
  run_plan(state, Mode::Transpose, "2:0:1:3", planes(state, type));
}

void turn_planes(benchmark::State& state, ElementType type) {
  run_plan(state, Mode::Transpose, "1:0:2:3", planes(state, type));
}

void turn_pixels(benchmark::State& state, ElementType type) {
  run_plan(state, Mode::Transpose, "0:2:1:3", picture(state, type));
}

void stand(benchmark::State& state, const std::string& option, ElementType type) {
  run_plan(state, Mode::Stand, option, picture(state, type));
}

void clamp(benchmark::State& state, ElementType type) {
  run_plan(state, Mode::Clamp, "10:200", picture(state, type));
}

void padding(benchmark::State& state, ElementType type) {
  run_plan(state, Mode::Padding, "left:8,right:8,top:8,bottom:8", planes(state, type));
}

void floor_copy(benchmark::State& state, ElementType type) {
  const size_t bytes = elements(state) * element_size(type);
  Memory in(bytes), out(bytes);
  for (auto _ : state) {
    std::memcpy(out.bytes.data(), in.bytes.data(), bytes);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(elements(state)));
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->Args({224, 224})->Args({640, 480})->Args({1920, 1080});
}

constexpr auto kU8 = ElementType::UInt8;
constexpr auto kF32 = ElementType::Float32;
constexpr const char* kMeans =
    "typecast:float32,per-channel:true@0,add:-123.675@0,add:-116.28@1,add:-103.53@2,"
    "div:58.395@0,div:57.12@1,div:57.375@2";

BENCHMARK(floor_plain_loop)->Apply(sizes);
BENCHMARK(floor_pass)->Apply(sizes);
BENCHMARK(floor_streamed_pass)->Apply(sizes);
BENCHMARK_CAPTURE(arithmetic, add_div, "typecast:float32,add:-127.5,div:127.5", kU8)->Apply(sizes);
BENCHMARK_CAPTURE(arithmetic, add_mul, "typecast:float32,add:-127.5,mul:0.0078", kU8)->Apply(sizes);
BENCHMARK_CAPTURE(arithmetic, per_channel, kMeans, kU8)->Apply(sizes);
BENCHMARK_CAPTURE(arithmetic, f32_add_div, "add:-127.5,div:127.5", kF32)->Apply(sizes);
BENCHMARK_CAPTURE(arithmetic, u8_add_mul, "add:5,mul:2", kU8)->Apply(sizes);
BENCHMARK(arithmetic_plain_path)->Apply(sizes);
BENCHMARK_CAPTURE(typecast, u8_to_f32, "float32", kU8)->Apply(sizes);
BENCHMARK_CAPTURE(typecast, f32_to_u8, "uint8", kF32)->Apply(sizes);
BENCHMARK_CAPTURE(typecast, f32_to_f16, "float16", kF32)->Apply(sizes);
BENCHMARK_CAPTURE(typecast, u8_to_f16, "float16", kU8)->Apply(sizes);
BENCHMARK_CAPTURE(floor_copy, u8, kU8)->Apply(sizes);
BENCHMARK_CAPTURE(to_planes, u8, kU8)->Apply(sizes);
BENCHMARK_CAPTURE(to_pixels, u8, kU8)->Apply(sizes);
BENCHMARK_CAPTURE(turn_planes, u8, kU8)->Apply(sizes);
BENCHMARK_CAPTURE(turn_pixels, u8, kU8)->Apply(sizes);
BENCHMARK_CAPTURE(floor_copy, f32, kF32)->Apply(sizes);
BENCHMARK_CAPTURE(to_planes, f32, kF32)->Apply(sizes);
BENCHMARK_CAPTURE(to_pixels, f32, kF32)->Apply(sizes);
BENCHMARK_CAPTURE(turn_planes, f32, kF32)->Apply(sizes);
BENCHMARK_CAPTURE(turn_pixels, f32, kF32)->Apply(sizes);
BENCHMARK_CAPTURE(stand, u8, "default", kU8)->Apply(sizes);
BENCHMARK_CAPTURE(stand, u8_to_f32, "default:float32", kU8)->Apply(sizes);
BENCHMARK_CAPTURE(stand, f32, "default", kF32)->Apply(sizes);
BENCHMARK_CAPTURE(stand, u8_channels_to_f32, "default:float32,per-channel:true", kU8)->Apply(sizes);
BENCHMARK_CAPTURE(clamp, u8, kU8)->Apply(sizes);
BENCHMARK_CAPTURE(clamp, f32, kF32)->Apply(sizes);
BENCHMARK_CAPTURE(padding, u8, kU8)->Apply(sizes);

}  // namespace
}  // namespace weir

BENCHMARK_MAIN();
#endif
