// Topics, and the queue of received messages.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/mqtt_message.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "says.hpp"
#include "transport/mqtt/receive_queue.hpp"
#include "transport/mqtt/sent_messages.hpp"

namespace weir::transport {
namespace mqtt_message_test {

using namespace std::chrono_literals;
using namespace std::string_literals;

MqttMessage message(const std::string& topic, size_t bytes) {
  return {.topic = topic, .payload = std::vector<std::byte>(bytes), .properties = {}};
}

TEST(MqttTopic, AcceptsTopicsOfTheStandard) {
  for (const char* topic : {"a", "/", "a/b", "/finance", "sensor 1/temperature", "größe"})
    EXPECT_TRUE(check_topic("pub-topic", topic)) << topic;
  for (const char* filter : {"#", "+", "a/#", "+/b/+", "a/+/#", "/+"})
    EXPECT_TRUE(check_topic_filter("sub-topic", filter)) << filter;
}

TEST(MqttTopic, RejectsOthers) {
  for (const std::string& topic :
       {""s, "a/#"s, "a+"s, "+/b"s, "a\0b"s, "\xff"s, std::string(65536, 'a')})
    EXPECT_REFUSED(check_topic("pub-topic", topic), OPTION_VALUE,
                   "the property pub-topic is not an MQTT topic");
  for (const std::string& filter : {""s, "a#"s, "#/a"s, "a/b+"s, "++"s, "a\0"s})
    EXPECT_REFUSED(check_topic_filter("sub-topic", filter), OPTION_VALUE,
                   "fix: sub-topic=camera/tensors");
  EXPECT_SAYS(check_topic("topic", "a\0b"s).error().message(), "offered: \"a\\x00b\"");
}

TEST(ReceiveQueue, DropsTheOldestBeyondItsLimits) {
  ReceiveQueue queue(3, 110);
  for (const char* topic : {"a", "b", "c", "d"}) queue.push(message(topic, 10));
  EXPECT_EQ(queue.dropped(), 1u);
  EXPECT_EQ(queue.pop(0ms)->topic, "b");
  queue.push(message("e", 90));
  EXPECT_EQ(queue.dropped(), 2u);
  EXPECT_EQ(queue.pop(0ms)->topic, "d");
  EXPECT_EQ(queue.pop(0ms)->topic, "e");
  EXPECT_FALSE(queue.pop(0ms));
}

TEST(ReceiveQueue, DropsAMessageBeyondItsLimitsAlone) {
  ReceiveQueue queue(3, 100);
  queue.push(message("a", 10));
  queue.push(message("too large", 101));
  EXPECT_EQ(queue.dropped(), 1u);
  EXPECT_EQ(queue.pop(0ms)->topic, "a");
  EXPECT_FALSE(queue.pop(0ms));
}

// A broker can send any number of user properties with a payload of one byte.
TEST(ReceiveQueue, CountsTopicsAndPropertiesToo) {
  const auto pushed = [](MqttMessage large) {
    ReceiveQueue queue(3, 1000);
    queue.push(std::move(large));
    return queue.pop(0ms).has_value();
  };
  EXPECT_FALSE(pushed(message(std::string(1001, 'a'), 0)));
  EXPECT_FALSE(pushed({.properties = {.content_type = std::string(1001, 'a')}}));
  EXPECT_FALSE(pushed({.properties = {.response_topic = std::string(1001, 'a')}}));
  EXPECT_FALSE(pushed({.properties = {.correlation_data = std::vector<std::byte>(1001)}}));
  EXPECT_FALSE(pushed({.properties = {.user = {{std::string(501, 'a'), std::string(500, 'b')}}}}));
  const std::vector<std::pair<std::string, std::string>> empty(100);
  EXPECT_FALSE(pushed({.properties = {.user = empty}}));
  EXPECT_TRUE(pushed({.properties = {.user = {{"caps", "other/tensors"}}}}));
}

TEST(ReceiveQueue, WaitsForTimesOfAnyLength) {
  ReceiveQueue queue(3, 100);
  std::thread sender([&] { queue.push(message("a", 1)); });
  EXPECT_TRUE(queue.pop(std::chrono::milliseconds::max()));
  sender.join();
}

TEST(ReceiveQueue, EndsWaitsWhenInterrupted) {
  ReceiveQueue queue(3, 100);
  std::thread waiting([&] { EXPECT_FALSE(queue.pop(1h)); });
  queue.set_interrupted(true);
  waiting.join();
  queue.push(message("a", 1));
  EXPECT_FALSE(queue.pop(1h));
  queue.set_interrupted(false);
  EXPECT_TRUE(queue.pop(0ms));
}

TEST(SentMessages, KnowsEndsThatComeBeforeNumbers) {
  SentMessages sent;
  sent.begin();
  EXPECT_FALSE(sent.empty());
  EXPECT_TRUE(sent.end(7));
  EXPECT_TRUE(sent.add(7, 10, 0));
  EXPECT_TRUE(sent.empty());
  EXPECT_FALSE(sent.end(7));
}

TEST(SentMessages, HasRoomForOneMessageOfAnySize) {
  SentMessages sent;
  EXPECT_TRUE(sent.has_room(1000, 2, 100));
  sent.begin();
  EXPECT_FALSE(sent.add(1, 1000, 1));
  EXPECT_FALSE(sent.has_room(1, 2, 100));
  EXPECT_TRUE(sent.has_room(1, 2, 2000));
  EXPECT_FALSE(sent.has_room(1, 1, 2000));
  EXPECT_EQ(sent.lose_unacknowledged(), 0u);
  sent.begin();
  sent.add(2, 10, 0);
  EXPECT_EQ(sent.lose_unacknowledged(), 1u);
  EXPECT_TRUE(sent.end(1));
  EXPECT_TRUE(sent.empty());
}

}  // namespace mqtt_message_test
}  // namespace weir::transport
