// Tests filters of the application: registering, calling, rejecting.
// SPDX-License-Identifier: LGPL-2.1-or-later

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <thread>

#include "core/custom/custom_easy.hpp"
#include "core/infer/model/model.hpp"
#include "core/infer/module/host.hpp"
#include "core/infer/module/module_library.hpp"
#include "says.hpp"
#include "weir/module.hpp"

namespace weir::custom {
namespace custom_easy_test {

// Returns *data; above 100 also sets an error.
int return_data(const weir_host* host, const weir_frame*, weir_frame*, void* data,
                weir_error* error) {
  const int wanted = *static_cast<int*>(data);
  if (wanted > 100)
    return host->fail(error, wanted, "as ordered", "this", "that", "here", "correct it");
  return wanted;
}

struct Description {
  weir_tensor_info input = tensor_info("x", WEIR_FLOAT32, {2, 3});
  weir_tensor_info output = tensor_info("y", WEIR_UINT8, {4});
  int data = 0;
  weir_filter filter{};
  Description() {
    filter.struct_size = sizeof filter;
    filter.n_inputs = filter.n_outputs = 1;
    filter.inputs = &input;
    filter.outputs = &output;
    filter.invoke = return_data;
    filter.data = &data;
  }
};

std::string message_of(int result, weir_error* error) {
  EXPECT_LT(result, 0);
  EXPECT_NE(error, nullptr);
  const std::unique_ptr<weir_error> owned(error);
  return owned ? owned->error.message() : "";
}
std::string refusal(const Description& description, const char* name = "refused") {
  weir_error* error = nullptr;
  const int result = weir_filter_register(name, &description.filter, &error);
  return message_of(result, error);
}

TEST(NamedFilter, IsAModelOfTheEngineCustomEasy) {
  Description description;
  description.filter.release = [](void*) {};
  ASSERT_EQ(weir_filter_register("named", &description.filter, nullptr), WEIR_OK);
  const auto engine = infer::ModuleLibrary::instance().engine("custom-easy");
  ASSERT_TRUE(engine) << engine.error().message();
  infer::OpenOptions options;
  options.paths = {"named"};
  const auto model = infer::Model::open(**engine, options);
  ASSERT_TRUE(model) << model.error().message();
  description.input.name = "gone";
  ASSERT_EQ((*model)->inputs().size(), 1u);
  EXPECT_STREQ((*model)->inputs()[0].name, "x");
  EXPECT_EQ(describe((*model)->inputs()[0]), "float32 3:2");
  EXPECT_EQ(describe((*model)->outputs()[0]), "uint8 4");
  EXPECT_EQ((*model)->info().flags, 0u);
  EXPECT_EQ(weir_filter_unregister("named"), WEIR_OK);
  auto session = infer::Session::create(*model);
  ASSERT_TRUE(session) << "what runs goes on";
  weir_frame frame{};
  EXPECT_TRUE(*(*session)->invoke(frame, frame));
  description.data = 1;
  EXPECT_FALSE(*(*session)->invoke(frame, frame)) << "above 0 drops the frame";
}

// Without release, the data may be freed once the filter is unregistered.
TEST(NamedFilter, WithoutReleaseIsNotCalledAfterUnregister) {
  struct Slow : Description {
    std::promise<void> entered, unregistered;
    std::atomic<bool> has_ended = false;
  } slow;
  slow.filter.data = &slow;
  slow.filter.invoke = [](const weir_host*, const weir_frame*, weir_frame*, void* data,
                          weir_error*) {
    auto* to = static_cast<Slow*>(data);
    to->entered.set_value();
    to->unregistered.get_future().wait_for(std::chrono::milliseconds(50));
    to->has_ended = true;
    return 0;
  };
  ASSERT_EQ(weir_filter_register("slow", &slow.filter, nullptr), WEIR_OK);
  const auto filter = *find_filter("slow");
  weir_frame frame{};
  std::jthread caller([&] { EXPECT_TRUE(filter->invoke(frame, frame)); });
  slow.entered.get_future().wait();
  EXPECT_EQ(weir_filter_unregister("slow"), WEIR_OK);
  EXPECT_TRUE(slow.has_ended) << "the call that ran is awaited";
  slow.unregistered.set_value();
  caller.join();
  EXPECT_REFUSED(filter->invoke(frame, frame), CALLBACK_UNKNOWN, "slow is no longer registered");
}

TEST(NamedFilter, MayUnregisterItself) {
  Description description;
  description.filter.invoke = [](const weir_host*, const weir_frame*, weir_frame*, void*,
                                 weir_error*) { return weir_filter_unregister("own"); };
  ASSERT_EQ(weir_filter_register("own", &description.filter, nullptr), WEIR_OK);
  const auto filter = *find_filter("own");
  weir_frame frame{};
  EXPECT_TRUE(filter->invoke(frame, frame));
  EXPECT_FALSE(filter->invoke(frame, frame));
}

TEST(NamedFilter, ReportsWhyItFailed) {
  Description description;
  const auto filter = NamedFilter::make("broken", description.filter);
  ASSERT_TRUE(filter);
  weir_frame frame{};
  description.data = WEIR_SPEC_MISMATCH;
  const auto outcome = (*filter)->invoke(frame, frame);
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().message(),
            "WEIR-2001: the filter broken failed: as ordered\n  offered: this\n  needed: that\n"
            "  first difference: here\n  fix: correct it");
  description.data = -22;
  const auto silent = (*filter)->invoke(frame, frame);
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().code, Code::CALLBACK_FAILED);
  EXPECT_SAYS(silent.error().message(), "the filter broken failed without an error message");
  EXPECT_SAYS(silent.error().message(), "offered: it returned -22");
}

TEST(NamedFilter, IsReleasedOnceWithItsLastUser) {
  struct Counted : Description {
    int released = 0;
  } counted;
  counted.filter.data = &counted;
  counted.filter.invoke = [](const weir_host*, const weir_frame*, weir_frame*, void*, weir_error*) {
    return 0;
  };
  counted.filter.release = [](void* data) { ++static_cast<Counted*>(data)->released; };
  ASSERT_EQ(weir_filter_register("counted", &counted.filter, nullptr), WEIR_OK);
  EXPECT_EQ(weir_filter_register("counted", &counted.filter, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(counted.released, 0) << "what is refused stays the caller's";
  auto used = find_filter("counted");
  ASSERT_TRUE(used);
  EXPECT_EQ(weir_filter_unregister("counted"), WEIR_OK);
  EXPECT_EQ(counted.released, 0) << "it is in use";
  used->reset();
  EXPECT_EQ(counted.released, 1);
  EXPECT_EQ(weir_filter_unregister("counted"), -WEIR_CALLBACK_UNKNOWN);
  EXPECT_EQ(weir_filter_unregister(nullptr), -WEIR_CALLBACK_UNKNOWN);
  ASSERT_EQ(weir_filter_register("counted", &counted.filter, nullptr), WEIR_OK);
  EXPECT_EQ(weir_filter_unregister("counted"), WEIR_OK);
  EXPECT_EQ(counted.released, 2) << "at once if it is unused";
}

TEST(NamedFilter, UnknownNameIsReported) {
  const Description description;
  ASSERT_EQ(weir_filter_register("doubler", &description.filter, nullptr), WEIR_OK);
  const auto found = find_filter("dubler");
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Code::CALLBACK_UNKNOWN);
  const std::string text = found.error().message();
  EXPECT_SAYS(text, "no filter is registered under this name");
  EXPECT_SAYS(text, "offered: framework=custom-easy model=dubler");
  EXPECT_SAYS(text, "needed: one of: doubler");
  EXPECT_SAYS(text, "first difference: did you mean doubler?");
  EXPECT_SAYS(text, "fix: weir_filter_register(\"dubler\", ...) before the pipeline starts");
  EXPECT_EQ(weir_filter_unregister("doubler"), WEIR_OK);
  EXPECT_SAYS(find_filter("dubler").error().message(), "needed: one of: none");
}

TEST(NamedFilter, IsRejectedWithAMessageForEachFault) {
  const auto with = [](auto&& change) {
    Description description;
    change(description);
    return refusal(description);
  };
  EXPECT_SAYS(refusal({}, ""), "its name");
  EXPECT_SAYS(refusal({}, "a,b"), "a name without a comma");
  EXPECT_SAYS(refusal({}, "Auto"), "a name without a comma that is not auto or any");
  EXPECT_SAYS(with([](auto& d) { d.filter.struct_size = 8; }), "offered: struct_size 8");
  EXPECT_SAYS(with([](auto& d) { d.filter.invoke = nullptr; }), "offered: no invoke");
  EXPECT_SAYS(with([](auto& d) { d.filter.n_inputs = 0; }), "offered: 0 inputs");
  EXPECT_SAYS(with([](auto& d) { d.filter.outputs = nullptr; }), "offered: 0 outputs");
  EXPECT_SAYS(with([](auto& d) { d.filter.n_outputs = 257; }), "offered: 257 outputs");
  EXPECT_SAYS(with([](auto& d) { d.output.type = 99; }), "offered: output 0 with type 99");
  EXPECT_SAYS(with([](auto& d) { d.input.rank = 17; }), "offered: input 0 with rank 17");
  EXPECT_SAYS(with([](auto& d) { d.input.shape[1] = 0; }), "input 0 with extent 0 of axis 1");
  EXPECT_SAYS(with([](auto& d) { d.input.shape[0] = -2; }), "input 0 with extent -2 of axis 0");
  EXPECT_SAYS(with([](auto& d) { d.input.shape[0] = INT64_MAX; }),
              "input 0 with extent 9223372036854775807 of axis 0");
  EXPECT_SAYS(with([](auto& d) { d.input.shape[0] = d.input.shape[1] = UINT32_MAX; }),
              "offered: input 0 with float32 4294967295:4294967295");
  EXPECT_SAYS(with([](auto& d) { d.output.shape[0] = -1; }), "offered: output 0 is open: uint8 ?");
  EXPECT_SAYS(with([](auto& d) { d.output.type = WEIR_TYPE_END; }), "WEIR_FILTER_DYNAMIC");
  weir_error* error = nullptr;
  const int result = weir_filter_register("none", nullptr, &error);
  EXPECT_SAYS(message_of(result, error), "offered: no description");
  EXPECT_FALSE(find_filter("refused"));
}

TEST(NamedFilter, ImpossibleShapeIsAnError) {
  Description description;
  description.output.shape[0] = -1;
  description.filter.resolve = [](const weir_host*, const weir_tensor_info*, uint32_t,
                                  weir_tensor_info* out, uint32_t, void* data, weir_error*) {
    out[0].shape[0] = *static_cast<int*>(data);
    out[0].name = "something else";
    return 0;
  };
  const auto filter = NamedFilter::make("shapes", description.filter);
  ASSERT_TRUE(filter);
  description.data = 7;
  weir_tensor_info out = description.output;
  ASSERT_TRUE((*filter)->resolve((*filter)->inputs(), {&out, 1}));
  EXPECT_EQ(describe(out), "uint8 7");
  EXPECT_STREQ(out.name, "y");
  description.data = 0;
  const auto status = (*filter)->resolve((*filter)->inputs(), {&out, 1});
  ASSERT_FALSE(status);
  EXPECT_SAYS(status.error().message(), "the filter shapes declares an invalid tensor");
  EXPECT_SAYS(status.error().message(), "offered: output 0 with extent 0 of axis 0");
}

TEST(NamedFilter, RejectsATakenName) {
  const auto& engine = custom_easy_engine();
  infer::OpenOptions options;
  options.paths = {"a", "b"};
  const auto model = infer::Model::open(engine, options);
  ASSERT_FALSE(model);
  EXPECT_SAYS(model.error().message(), "offered: model=a,b");
}

}  // namespace custom_easy_test
}  // namespace weir::custom
