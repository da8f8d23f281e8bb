// tensor_filter framework=custom-easy: filters that the program registers with the loaded plug-in.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>
#include <atomic>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "becomes.hpp"
#include "elements/tensor_filter/custom_easy_test_support.hpp"

namespace custom_easy_test {

using namespace weir::test;
using weir::FilterDescription;
using weir::RegisteredFilter;
using weir::tensor_info;

const std::string kFour = tensors("float32", "4:1");

FilterDescription four() {
  return {.inputs = {tensor_info("x", WEIR_FLOAT32, {1, 4})},
          .outputs = {tensor_info("y", WEIR_FLOAT32, {1, 4})}};
}
template <class Function>
RegisteredFilter registered(Function function, FilterDescription description = four(),
                            const std::string& name = "named") {
  return {name, std::move(description), std::move(function), functions()};
}
using In = std::span<const weir_tensor>;
using Out = std::span<weir_tensor>;
void twice(In in, Out out) {
  const auto x = weir::elements<const float>(in[0]);
  const auto y = weir::elements<float>(out[0]);
  for (size_t i = 0; i < x.size(); ++i) y[i] = 2 * x[i];
}
std::string line(const std::string& more = "") {
  return "tensor_filter framework=custom-easy model=named " + more;
}
using Floats = std::vector<float>;
Floats pushed(const Harness& h, const Floats& in) {
  if (gst_harness_push(h.get(), frame<float>(in)) != GST_FLOW_OK) return {};
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  return out ? values<float>(out.get()) : Floats{};
}
// The error text when a frame is rejected.
std::string frame_error(const Harness& h) {
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame<float>({1, 2, 3, 4})), GST_FLOW_ERROR);
  EXPECT_EQ(stat(h, "tensor_filter", "dropped-error"), 1u);
  return errors.next();
}

TEST(TensorFilterCustomEasy, RunsALambdaOverEachFrame) {
  const auto named = registered(twice);
  auto h = make_harness(line(), kFour);
  EXPECT_EQ(pushed(h, {1, 2, 3, 4}), (Floats{2, 4, 6, 8}));
  EXPECT_EQ(pushed(h, {-1, 0, 1, 2}), (Floats{-2, 0, 2, 4}));
  EXPECT_EQ(stat(h, "tensor_filter", "bytes-copied"), 0u);
  EXPECT_SAYS(caps_text(h), "dimension=(string)4:1");
}

TEST(TensorFilterCustomEasy, OwnsTheLambdaWithItsState) {
  struct Gone {
    explicit Gone(bool* flag) : flag_(flag) {}
    Gone(const Gone&) = delete;
    Gone& operator=(const Gone&) = delete;
    ~Gone() { *flag_ = true; }
    bool* flag_;
  };
  bool gone = false;
  auto description = four();
  description.stateful = true;
  auto named = std::make_unique<RegisteredFilter>(
      registered([count = 0.f, kept = std::make_unique<Gone>(&gone)](
                     In, Out out) mutable { weir::elements<float>(out[0])[0] = ++count; },
                 std::move(description)));
  auto h = make_harness(line(), kFour);
  EXPECT_EQ(pushed(h, {0, 0, 0, 0}).at(0), 1);
  EXPECT_EQ(pushed(h, {0, 0, 0, 0}).at(0), 2);
  named.reset();
  EXPECT_EQ(pushed(h, {0, 0, 0, 0}).at(0), 3) << "a running pipeline keeps it";
  EXPECT_FALSE(gone);
  EXPECT_SAYS(start_error(line()), "no filter is registered under this name");
  h.reset();
  EXPECT_TRUE(gone);
}

TEST(TensorFilterCustomEasy, DropsAFrameThatTheLambdaDrops) {
  const auto named = registered([](const weir_frame& in, weir_frame& out) {
    const auto x = weir::elements<const float>(in.tensors[0]);
    std::copy(x.begin(), x.end(), weir::elements<float>(out.tensors[0]).begin());
    return x[0] > 0;
  });
  auto h = make_harness(line(), kFour);
  EXPECT_EQ(pushed(h, {1, 2, 3, 4}), (Floats{1, 2, 3, 4}));
  EXPECT_EQ(pushed(h, {0, 2, 3, 4}), Floats{});
  EXPECT_EQ(stat(h, "tensor_filter", "dropped-policy"), 1u);
}

TEST(TensorFilterCustomEasy, FollowsTheStreamIfItsShapesAreOpen) {
  FilterDescription any{.inputs = {tensor_info("x", WEIR_FLOAT32, {-1, -1})},
                        .outputs = {tensor_info("y", WEIR_FLOAT32, {-1, -1})},
                        .resolve = [](auto in, auto out) {
                          out[0].shape[0] = in[0].shape[0];
                          out[0].shape[1] = in[0].shape[1];
                        }};
  const auto named = registered(twice, std::move(any));
  auto h = make_harness(line(), tensors("float32", "3:2"));
  EXPECT_EQ(pushed(h, {1, 2, 3, 4, 5, 6}), (Floats{2, 4, 6, 8, 10, 12}));
  EXPECT_SAYS(caps_text(h), "dimension=(string)3:2");
}

// The sizes of a dynamic filter come with each frame, in flexible tensors.
FilterDescription dynamic() {
  return {.inputs = {tensor_info("x", WEIR_FLOAT32, {1, 4})},
          .outputs = {tensor_info("y", WEIR_FLOAT32, {-1})},
          .dynamic = true};
}
void positives(In in, Out out) {
  Floats kept;
  for (const float x : weir::elements<const float>(in[0]))
    if (x > 0) kept.push_back(x);
  weir::allocate(&out[0], tensor_info("y", WEIR_FLOAT32, {static_cast<int64_t>(kept.size())}),
                 kept.size() * sizeof(float));
  std::copy(kept.begin(), kept.end(), weir::elements<float>(out[0]).begin());
}

TEST(TensorFilterCustomEasy, AllowsSizesThatChangeWithEachFrame) {
  const auto named = registered(positives, dynamic());
  auto h = make_harness(line("invoke-dynamic=true"), kFour);
  constexpr size_t kHeader = 32;  // words
  for (const auto& in : {Floats{1, -2, 3, 4}, Floats{-1, -2, 5, -4}}) {
    auto out = pushed(h, in);
    ASSERT_GT(out.size(), kHeader);
    Floats expected;
    std::copy_if(in.begin(), in.end(), std::back_inserter(expected), [](float x) { return x > 0; });
    EXPECT_EQ(Floats(out.begin() + kHeader, out.end()), expected);
  }
  EXPECT_SAYS(caps_text(h), "format=(string)flexible");
}

TEST(TensorFilterCustomEasy, RejectsContradictingSizes) {
  {
    const auto named = registered(positives, dynamic());
    const auto text = start_error(line());
    EXPECT_SAYS(text, "WEIR-1004: the filter named decides its sizes with each frame");
    EXPECT_SAYS(text, "offered: invoke-dynamic=false");
    EXPECT_SAYS(text, "fix: tensor_filter framework=custom-easy model=named invoke-dynamic=true");
  }
  const auto named = registered(twice);
  const auto text = start_error(line("invoke-dynamic=true"));
  EXPECT_SAYS(text, "WEIR-1004: the filter named has outputs of fixed sizes");
  EXPECT_SAYS(text, "needed: invoke-dynamic=false");
}

TEST(TensorFilterCustomEasy, ReportsTheRegisteredFilters) {
  const auto named = registered(twice);
  const auto other = registered(twice, four(), "another");
  const auto text = start_error("tensor_filter framework=custom-easy model=name");
  EXPECT_SAYS(text, "WEIR-5002: no filter is registered under this name");
  EXPECT_SAYS(text, "needed: one of: another, named");
  EXPECT_SAYS(text, "did you mean named?");
}

TEST(TensorFilterCustomEasy, RejectsASecondFilterOfTheSameName) {
  const auto named = registered(twice);
  try {
    const auto second = registered([](In, Out) {});
    FAIL() << "it was registered";
  } catch (const weir::Failure& failure) {
    EXPECT_SAYS(std::string(failure.what()), "WEIR-1004: the filter named cannot be registered");
    EXPECT_SAYS(std::string(failure.what()), "offered: another filter has this name");
  }
  auto h = make_harness(line(), kFour);
  EXPECT_EQ(pushed(h, {1, 1, 1, 1}), (Floats{2, 2, 2, 2})) << "the first one is kept";
}

TEST(TensorFilterCustomEasy, RejectsAStreamOfOtherTensors) {
  const auto named = registered(twice);
  auto h = make_harness(line());
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), tensors("float32", "5:1").c_str());
  EXPECT_EQ(gst_harness_push(h.get(), frame<float>({1, 2, 3, 4, 5})), GST_FLOW_NOT_NEGOTIATED);
  const auto text = errors.next();
  EXPECT_SAYS(text, "WEIR-2001");
  EXPECT_SAYS(text, "4:1");
}

TEST(TensorFilterCustomEasy, ReportsTheTextOfAnException) {
  const auto named = registered([](In, Out) -> bool { throw std::runtime_error("no, not today"); });
  EXPECT_SAYS(frame_error(make_harness(line(), kFour)),
              "WEIR-5003: the filter named failed: no, not today");
}

TEST(TensorFilterCustomEasy, ReportsTheTextOfAFailure) {
  const auto named = registered([](In, Out) {
    throw weir::Failure({.code = weir::Code::SPEC_MISMATCH,
                         .what = "too dark",
                         .offered = "3",
                         .needed = "above 5",
                         .difference = "pixel 0",
                         .fix = "a lamp"});
  });
  const auto text = frame_error(make_harness(line(), kFour));
  EXPECT_SAYS(text, "WEIR-2001: the filter named failed: too dark");
  EXPECT_SAYS(text, "fix: a lamp");
}

TEST(TensorFilterCustomEasy, SurvivesThrownValuesThatAreNotExceptions) {
  const auto named = registered([](In, Out) { throw 5; });
  EXPECT_SAYS(frame_error(make_harness(line(), kFour)),
              "the filter named failed: an unknown exception");
}

TEST(TensorFilterCustomEasy, RejectsModifiedOutputs) {
  static float elsewhere[4];
  const auto meddled = [](const std::function<void(weir_tensor&)>& meddle) {
    const auto named = registered([meddle](In, Out out) { meddle(out[0]); });
    return frame_error(make_harness(line(), kFour));
  };
  for (const auto& text : {meddled([](weir_tensor& t) { t.data = elsewhere; }),
                           meddled([](weir_tensor& t) { t.bytes = 400; }),
                           meddled([](weir_tensor& t) { t.info.shape[1] = 400; })})
    EXPECT_SAYS(text, "WEIR-3006");
}

TEST(TensorFilterCustomEasy, RejectsADynamicFilterWithoutMemory) {
  const auto named = registered([](In, Out) {}, dynamic());
  EXPECT_SAYS(frame_error(make_harness(line("invoke-dynamic=true"), kFour)),
              "the size of the engine's output does not match its shape");
}

// It runs on one thread at a time: the workers of one element and other elements.
TEST(TensorFilterCustomEasy, IsCalledByOneThreadAtATime) {
  std::atomic<int> inside{0}, max{0};
  const auto named = registered([&](In in, Out out) {
    max = std::max(max.load(), ++inside);
    twice(in, out);
    g_thread_yield();
    --inside;
  });
  auto first = make_harness(line("workers=4"), kFour),
       second = make_harness(line("workers=4"), kFour);
  for (int i = 0; i < 100; ++i)
    for (const auto* h : {&first, &second})
      ASSERT_EQ(gst_harness_push(h->get(), frame<float>({static_cast<float>(i), 0, 0, 0})),
                GST_FLOW_OK);
  for (int i = 0; i < 100; ++i)
    for (const auto* h : {&first, &second}) {
      const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h->get()));
      EXPECT_EQ(values<float>(out.get())[0], 2.f * static_cast<float>(i));
    }
  EXPECT_EQ(max, 1);
}

TEST(TensorFilterCustomEasy, IsCalledByAllWorkersIfDeclaredThreadSafe) {
  std::atomic<int> inside{0};
  auto description = four();
  description.thread_safe = true;
  const auto named = registered(
      [&](In in, Out out) {
        ++inside;
        EXPECT_TRUE(becomes_true([&] { return inside >= 2; }, "the other thread in the filter"));
        twice(in, out);
      },
      std::move(description));
  auto h = make_harness(line("workers=2"), kFour);
  for (int i = 0; i < 2; ++i)
    ASSERT_EQ(gst_harness_push(h.get(), frame<float>({1, 2, 3, 4})), GST_FLOW_OK);
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(Ref<GstBuffer>::adopt(gst_harness_pull(h.get())));
}

TEST(TensorFilterCustomEasy, RejectsWorkersWithState) {
  auto description = four();
  description.stateful = true;
  const auto named = registered(twice, std::move(description));
  EXPECT_SAYS(start_error(line("workers=2")), "the model keeps state from frame to frame");
}

}  // namespace custom_easy_test
