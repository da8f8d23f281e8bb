// Replacing models while frames flow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <future>
#include <thread>

#include "becomes.hpp"
#include "elements/tensor_filter/adder_test_support.hpp"

namespace model_reload_test {

using namespace weir::test;

GstEvent* update_event(const std::string& model) {
  return gst_event_new_custom(
      GST_EVENT_CUSTOM_DOWNSTREAM,
      gst_structure_new("evt_update_model", "model_files", G_TYPE_STRING, model.c_str(), nullptr));
}
void set_model(GstElement* filter, const std::string& model) {
  g_object_set(filter, "model", model.c_str(), nullptr);
}
void expect_ledger(GstElement* filter, uint64_t frames) {
  EXPECT_EQ(stat(filter, "received"), frames);
  EXPECT_EQ(stat(filter, "consumed"), frames);
  EXPECT_EQ(stat(filter, "pushed"), frames);
  EXPECT_EQ(stat(filter, "held"), 0u);
}
// Waits until the property `model` changes.
void wait_for_notify(GstElement* filter, const std::function<void()>& act) {
  std::promise<void> changed;
  const auto notify = +[](GObject*, GParamSpec*, gpointer data) {
    static_cast<std::promise<void>*>(data)->set_value();
  };
  const gulong id = g_signal_connect(filter, "notify::model", G_CALLBACK(notify), &changed);
  act();
  changed.get_future().wait();
  g_signal_handler_disconnect(filter, id);
}

TEST(ModelReload, TheModelIsReplacedWhenThePropertySetterReturns) {
  const AdderFiles files;
  auto h = make_harness(adder(files.model(1), "is-updatable=true"), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  EXPECT_EQ(pushed_sum(h), 1);
  set_model(filter.get(), files.model(2));
  EXPECT_EQ(pushed_sum(h), 2);
  EXPECT_EQ(stat(filter.get(), "reloads"), 1u);
  EXPECT_EQ(text_property(filter.get(), "model"), files.model(2));
  expect_ledger(filter.get(), 2);
}

// A filter whose model waits at a gate while it is reopened for another property.
struct OpenedAgain {
  explicit OpenedAgain(const std::string& model)
      : h(make_harness(adder(model, "is-updatable=true custom=gate:" + gate.reader() +
                                        ",events:" + events.writer()),
                       kAdderCaps)),
        filter(find_element(h, "tensor_filter")) {}
  void change_a_property() { g_object_set(filter.get(), "inputname", "other", nullptr); }
  std::future<float> push_later() {
    return std::async(std::launch::async, [this] { return pushed_sum(h); });
  }
  void wait_until_it_is_at_the_gate() {
    while (events.next() != 'g') continue;
  }

  Pipe gate, events;
  Harness h;
  Ref<GstElement> filter;
};

TEST(ModelReload, AFileReplacedDuringAReopenWins) {
  const AdderFiles files;
  const auto slow = files.model(1);
  OpenedAgain opened(slow);
  EXPECT_EQ(pushed_sum(opened.h), 1);
  files.model(1, "4 gate");
  opened.change_a_property();
  auto pushed = opened.push_later();
  opened.wait_until_it_is_at_the_gate();
  set_model(opened.filter.get(), files.model(2));
  opened.gate.put('x');
  EXPECT_EQ(pushed.get(), 2);
  EXPECT_EQ(text_property(opened.filter.get(), "model"), files.model(2));
}

TEST(ModelReload, TheSameFileReloadedDuringAReopenWins) {
  const AdderFiles files;
  const auto path = files.write("m", "1 4");
  OpenedAgain opened(path);
  files.write("m", "1 4 gate");
  opened.change_a_property();
  auto pushed = opened.push_later();
  opened.wait_until_it_is_at_the_gate();
  files.write("m", "5 4");
  set_model(opened.filter.get(), path);
  opened.gate.put('x');
  EXPECT_EQ(pushed.get(), 5);
}

TEST(ModelReload, AModelReopenedDuringAReplacementGetsTheNewFile) {
  const AdderFiles files;
  OpenedAgain opened(files.model(1));
  EXPECT_EQ(pushed_sum(opened.h), 1);
  const auto slow = files.model(2, "4 gate");
  auto replaced = std::async(std::launch::async, [&] { set_model(opened.filter.get(), slow); });
  opened.wait_until_it_is_at_the_gate();
  opened.change_a_property();
  EXPECT_EQ(pushed_sum(opened.h), 1);
  opened.gate.put('x');
  opened.gate.put('x');  // for the new model
  replaced.get();
  EXPECT_EQ(pushed_sum(opened.h), 2);
  EXPECT_EQ(text_property(opened.filter.get(), "model"), slow);
  EXPECT_EQ(text_property(opened.filter.get(), "inputname"), "other");
}

TEST(ModelReload, UsesAFileThatIsSetWhileTheElementStarts) {
  const AdderFiles files;
  OpenedAgain opened(files.model(1));
  gst_element_set_state(opened.filter.get(), GST_STATE_READY);
  files.model(1, "4 gate");
  auto started = std::async(std::launch::async, [&] {
    return gst_element_set_state(opened.filter.get(), GST_STATE_PLAYING);
  });
  opened.wait_until_it_is_at_the_gate();
  set_model(opened.filter.get(), files.model(2));
  opened.gate.put('x');
  EXPECT_EQ(started.get(), GST_STATE_CHANGE_SUCCESS);
  gst_harness_set_src_caps_str(opened.h.get(), kAdderCaps);
  EXPECT_EQ(pushed_sum(opened.h), 2);
  EXPECT_EQ(text_property(opened.filter.get(), "model"), files.model(2));
}

TEST(ModelReload, TheSameFileCanContainAnotherModel) {
  const AdderFiles files;
  const auto path = files.write("m", "1 4");
  auto h = make_harness(adder(path, "is-updatable=true"), kAdderCaps);
  EXPECT_EQ(pushed_sum(h), 1);
  files.write("m", "5 4");
  EXPECT_EQ(pushed_sum(h), 1);
  set_model(find_element(h, "tensor_filter").get(), path);
  EXPECT_EQ(pushed_sum(h), 5);
}

// Model n adds n, so outputs show which model processed each frame.
TEST(ModelReload, AHundredReloadsUnderLoadLoseNoFrame) {
  constexpr int kReloads = 100;
  const AdderFiles files;
  std::vector<std::string> models;
  for (int i = 0; i <= kReloads; ++i) models.push_back(files.model(i));
  auto h = make_harness(adder(models[0], "is-updatable=true"), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  std::atomic<int> begun{0}, done{0};
  std::thread reloads([&] {
    for (int i = 1; i <= kReloads; ++i) {
      begun = i;
      set_model(filter.get(), models[static_cast<size_t>(i)]);
      done = i;
    }
  });
  uint64_t frames = 0;
  for (float last = 0; last < kReloads; ++frames) {
    const int before = done;
    const float now = pushed_sum(h);
    ASSERT_GE(now, static_cast<float>(before)) << "a finished reload";
    ASSERT_LE(now, static_cast<float>(begun)) << "a reload that had not started";
    ASSERT_GE(now, last) << "an old model after a new one";
    last = now;
  }
  reloads.join();
  EXPECT_EQ(stat(filter.get(), "reloads"), static_cast<uint64_t>(kReloads));
  expect_ledger(filter.get(), frames);
}

// Frames run on several threads; their order and that of the models is kept.
TEST(ModelReload, ReloadsUnderWorkersKeepTheOrderOfTheModels) {
  constexpr int kReloads = 50;
  const AdderFiles files;
  std::vector<std::string> models;
  for (int i = 0; i <= kReloads; ++i) models.push_back(files.model(i));
  auto h = make_harness(adder(models[0], "is-updatable=true workers=3"), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  std::atomic<int> done{0};
  std::thread reloads([&] {
    for (int i = 1; i <= kReloads; ++i) {
      set_model(filter.get(), models[static_cast<size_t>(i)]);
      done = i;
    }
  });
  std::vector<int> min;  // the model that was installed when the frame arrived
  while (min.empty() || min.back() < kReloads) {
    min.push_back(done);
    ASSERT_EQ(gst_harness_push(h.get(), frame<float>({0, 0, 0, 0})), GST_FLOW_OK);
  }
  reloads.join();
  float last = 0;
  for (const int before : min) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    ASSERT_TRUE(out);
    const float now = values<float>(out.get())[0];
    ASSERT_GE(now, static_cast<float>(before));
    ASSERT_GE(now, last);
    last = now;
  }
  expect_ledger(filter.get(), min.size());
}

TEST(ModelReload, FollowsTheShapesOfAFlexibleStreamAcrossReloads) {
  const AdderFiles files;
  auto h = make_harness(adder(files.model(1), "is-updatable=true"),
                        "other/tensors,format=flexible,framerate=30/1");
  const auto filter = find_element(h, "tensor_filter");
  for (int i = 1; i <= 6; ++i) {
    const uint32_t rows = static_cast<uint32_t>(i % 3 + 1);
    std::vector<uint32_t> in(32 + 4 * rows, 0);
    const uint32_t head[] = {0xFEEDCCED, 0xDE001000, 7, 4, rows};
    std::copy(std::begin(head), std::end(head), in.begin());
    in[19] = 1, in[20] = 4;
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(in)));
    ASSERT_TRUE(out);
    const auto result = values<float>(out.get());
    ASSERT_EQ(result.size(), 32 + 4 * rows);
    EXPECT_EQ(result.back(), static_cast<float>(i));
    set_model(filter.get(), files.model(i + 1));
  }
}

TEST(ModelReload, AnIncompatibleModelIsRejectedWithBothShapes) {
  const AdderFiles files;
  auto h = make_harness(adder(files.model(1), "is-updatable=true"), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  Errors messages(h);
  EXPECT_EQ(pushed_sum(h), 1);
  set_model(filter.get(), files.model(2, "5"));
  const auto text = messages.next_warning();
  EXPECT_SAYS(text, "WEIR-3012: the new model cannot replace the one that runs");
  EXPECT_SAYS(text, "offered: " + files.model(2, "5") + ": in 1 tensor: float32 5:?");
  EXPECT_SAYS(text, "needed: " + files.model(1) + ": in 1 tensor: float32 4:?");
  EXPECT_EQ(text_property(filter.get(), "model"), files.model(1)) << "the running model";
  EXPECT_EQ(pushed_sum(h), 1);
  EXPECT_EQ(messages.next(), "") << "the stream continues";
}

TEST(ModelReload, AModelThatCannotBeOpenedOrRunIsRejected) {
  const AdderFiles files;
  auto h = make_harness(adder(files.model(1), "is-updatable=true custom=fail:3"), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  Errors messages(h);
  const std::pair<std::string, const char*> invalid[] = {
      {"/nowhere/m.add", "WEIR-3003: the model file does not exist"},
      {files.write("rubbish", "rubbish"), "WEIR-3004: no model of the adder"},
      {files.model(3), "WEIR-3006: ordered to fail"},
      {"", "WEIR-3003: no model is set"},
      {"mlagent://model/x/1", "mlagent://model/x/1"},
  };
  EXPECT_EQ(pushed_sum(h), 1);
  for (const auto& [model, message] : invalid) {
    set_model(filter.get(), model);
    EXPECT_SAYS(messages.next_warning(), message);
    EXPECT_EQ(text_property(filter.get(), "model"), files.model(1));
    EXPECT_EQ(pushed_sum(h), 1);
  }
  EXPECT_EQ(stat(filter.get(), "reloads"), 0u);
}

TEST(ModelReload, WithoutIsUpdatableTheModelAppliesAtTheNextStart) {
  const AdderFiles files;
  auto h = make_harness(adder(files.model(1)), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  Errors messages(h);
  EXPECT_EQ(pushed_sum(h), 1);
  set_model(filter.get(), files.model(2));
  EXPECT_SAYS(messages.next_warning(), "is-updatable is false");
  EXPECT_EQ(pushed_sum(h), 1);
}

// Opening the new model waits for the test; frames flow meanwhile.
TEST(ModelReload, AnEventReplacesTheModelWithoutBlockingFrames) {
  const AdderFiles files;
  const Pipe gate;
  auto h = make_harness(adder(files.model(1), "is-updatable=true custom=gate:" + gate.reader()),
                        kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  const auto slow = files.model(2, "4 gate");
  wait_for_notify(filter.get(), [&] {
    EXPECT_TRUE(gst_harness_push_event(h.get(), update_event(slow)));
    for (int i = 0; i < 10; ++i) EXPECT_EQ(pushed_sum(h), 1) << "while the new one is opened";
    gate.put('x');
  });
  EXPECT_EQ(pushed_sum(h), 2);
  EXPECT_EQ(text_property(filter.get(), "model"), slow);
  while (const auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get())))
    EXPECT_FALSE(gst_event_has_name(event.get(), "evt_update_model")) << "it is consumed";
  expect_ledger(filter.get(), 11);
}

TEST(ModelReload, OfSeveralEventsTheLastOneWins) {
  const AdderFiles files;
  const Pipe gate;
  auto h = make_harness(adder(files.model(1), "is-updatable=true custom=gate:" + gate.reader()),
                        kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  gst_harness_push_event(h.get(), update_event(files.model(2, "4 gate")));
  for (int i = 3; i < 9; ++i) gst_harness_push_event(h.get(), update_event(files.model(i)));
  const auto last = files.model(9);  // the file is complete before the request
  gst_harness_push_event(h.get(), update_event(last));
  gate.put('x');
  EXPECT_TRUE(becomes_true([&] { return text_property(filter.get(), "model") == last; },
                           "the model that was requested last"));
  EXPECT_EQ(pushed_sum(h), 9);
  EXPECT_LE(stat(filter.get(), "reloads"), 8u);
}

TEST(ModelReload, AnInvalidEventKeepsTheModel) {
  const AdderFiles files;
  auto h = make_harness(adder(files.model(1), "is-updatable=true"), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  Errors messages(h);
  gst_harness_push_event(h.get(),
                         gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM,
                                              gst_structure_new_empty("evt_update_model")));
  EXPECT_SAYS(messages.next_warning(), "the event evt_update_model contains no model");
  gst_harness_push_event(h.get(), update_event("/nowhere/m"));
  std::string text;
  EXPECT_TRUE(becomes_true([&] { return !(text = messages.next_warning()).empty(); }, "a warning"));
  EXPECT_SAYS(text, "WEIR-3003");
  EXPECT_EQ(pushed_sum(h), 1);
}

TEST(ModelReload, ForwardsTheEventIfNotUpdatable) {
  const AdderFiles files;
  auto h = make_harness(adder(files.model(1)), kAdderCaps);
  EXPECT_EQ(pushed_sum(h), 1);
  gst_harness_push_event(h.get(), update_event(files.model(2)));
  bool seen = false;
  while (const auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get())))
    seen = seen || gst_event_has_name(event.get(), "evt_update_model");
  EXPECT_TRUE(seen);
  EXPECT_EQ(pushed_sum(h), 1);
}

TEST(ModelReload, AStopWaitsForAModelThatIsBeingOpened) {
  const AdderFiles files;
  const Pipe gate, events;
  auto h = make_harness(adder(files.model(1), "is-updatable=true custom=gate:" + gate.reader() +
                                                  ",events:" + events.writer()),
                        kAdderCaps);
  EXPECT_EQ(events.next(), 'o');
  gst_harness_push_event(h.get(), update_event(files.model(2, "4 gate")));
  EXPECT_EQ(events.next(), 'g');
  gate.put('x');
  h.reset();
  std::string rest;
  for (int i = 0; i < 3; ++i) rest += events.next();
  EXPECT_EQ(std::count(rest.begin(), rest.end(), 'o'), 1);
  EXPECT_EQ(std::count(rest.begin(), rest.end(), 'c'), 2) << "both are closed";
}

}  // namespace model_reload_test
