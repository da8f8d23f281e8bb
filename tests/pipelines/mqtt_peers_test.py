#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The elements that use MQTT with clients of other projects: mosquitto_pub and mosquitto_sub, Paho for Python, mqtt of npm."""

import base64
import contextlib
import json
import os
import pathlib
import queue
import shutil
import subprocess
import sys
import tempfile
import unittest

import edge_peer
import mqtt_broker
import tap_runner

try:
    import paho.mqtt.client as paho
    from paho.mqtt.properties import Properties
except ImportError:
    paho = None

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
PEERS = SOURCE / "tests/support/peers"
SECONDS = 60
CAPS = "other/tensors,format=static,num_tensors=1,dimensions=4:1:1:1,types=uint8,framerate=30/1"
FRAMES = [bytes([i, 1, 2, 3]) for i in range(3)]


class Peers(unittest.TestCase):
    def setUp(self):
        if not mqtt_broker.find_mosquitto() or not shutil.which("mosquitto_sub"):
            self.skipTest("mosquitto is not installed: apt-get install mosquitto mosquitto-clients")
        cleanups = contextlib.ExitStack()
        self.addCleanup(cleanups.close)
        self.port = cleanups.enter_context(mqtt_broker.running_broker())
        self.folder = pathlib.Path(cleanups.enter_context(tempfile.TemporaryDirectory()))

    def start(self, *command, **options):
        process = subprocess.Popen([*map(str, command)], stdout=subprocess.PIPE, **options)
        for cleanup in (process.stdout.close, process.wait, process.kill):
            self.addCleanup(cleanup)
        return process

    def play(self, line):
        done = subprocess.run(["gst-launch-1.0", "-q", *line.split()], capture_output=True, text=True, timeout=SECONDS,
                              stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stderr)

    def send(self, sink, frames=FRAMES):
        (self.folder / "in").write_bytes(b"".join(frames))
        self.play(f"filesrc location={self.folder}/in blocksize=4 ! {CAPS} ! {sink}")

    def received(self, source, count):
        self.play(f"{source} num-buffers={count} ! {CAPS} ! filesink location={self.folder}/out")
        return (self.folder / "out").read_bytes()

    def edge(self, element, kind):
        return f"{element} connect-type={kind} dest-host=127.0.0.1 dest-port={self.port} topic=objects"

    def message(self, memory, **times):
        fields = {"sizes": [len(memory)], "base_time_epoch": 0, "sent_time_epoch": 1 << 62, "duration": None, "dts": None, "pts": None,
                  "caps": CAPS, **times}
        return edge_peer.encode_mqtt_header(fields) + memory


class Mosquitto(Peers):
    def test_mosquitto_sub_gets_the_messages_of_mqttsink(self):
        self.send(f"mqttsink port={self.port} pub-topic=t mqtt-qos=1")
        done = subprocess.run(["mosquitto_sub", "-p", str(self.port), "-t", "t", "-C", "1", "-N"], capture_output=True, timeout=SECONDS)
        fields = edge_peer.decode_mqtt_header(done.stdout[:1024])
        self.assertEqual((fields["sizes"], done.stdout[1024:]), ([4], FRAMES[-1]))
        self.assertIn("other/tensors", fields["caps"])

    def test_mqttsrc_gets_the_message_of_mosquitto_pub(self):
        subprocess.run(["mosquitto_pub", "-p", str(self.port), "-t", "t", "-q", "1", "-r", "-s"], input=self.message(b"abcd"), check=True,
                       timeout=SECONDS)
        self.assertEqual(self.received(f"mqttsrc port={self.port} sub-topic=t", 1), b"abcd")


@unittest.skipUnless(paho, "Paho is not installed: apt-get install python3-paho-mqtt")
class Paho(Peers):
    def client(self, topic, protocol=None):
        """A client that has subscribed, and the queue of its messages."""
        client, messages, ready = paho.Client(protocol=protocol or paho.MQTTv311), queue.Queue(), queue.Queue()
        client.on_message = lambda _client, _user, message: messages.put(message)
        client.on_subscribe = lambda *_: ready.put(None)
        client.connect("127.0.0.1", self.port)
        client.loop_start()
        self.addCleanup(client.loop_stop)
        self.addCleanup(client.disconnect)
        client.subscribe(topic, qos=1)
        ready.get(timeout=SECONDS)
        return client, messages

    def test_mqtt_5_has_caps_and_numbers_as_user_properties(self):
        _, messages = self.client("t", paho.MQTTv5)
        self.send(f"mqttsink port={self.port} pub-topic=t mqtt-qos=1 protocol=5")
        for number, frame in enumerate(FRAMES):
            message = messages.get(timeout=SECONDS)
            user = dict(message.properties.UserProperty)
            self.assertEqual((message.payload, user["seq"], message.properties.ContentType), (frame, str(number), "other/tensors"))
            self.assertIn("types=(string)uint8", user["caps"])
            self.assertFalse(message.retain)

    def test_a_pipeline_answers_requests(self):
        client, responses = self.client("responses", paho.MQTTv5)
        self.start("gst-launch-1.0", *f"mqttsrc port={self.port} protocol=5 sub-topic=ask mqtt-qos=1 ! "
                   f"tensor_transform mode=arithmetic option=add:1 ! mqttsink port={self.port} protocol=5 mqtt-qos=1".split())
        properties = Properties(paho.PacketTypes.PUBLISH if hasattr(paho, "PacketTypes") else 3)
        properties.ResponseTopic, properties.CorrelationData = "responses", b"number 7"
        properties.UserProperty = [("caps", CAPS), ("base-epoch", "1"), ("seq", "0")]
        for _ in range(SECONDS):  # until the pipeline has subscribed
            client.publish("ask", bytes([1, 2, 3, 4]), qos=1, properties=properties)
            with contextlib.suppress(queue.Empty):
                response = responses.get(timeout=1)
                break
        self.assertEqual((response.payload, response.properties.CorrelationData), (bytes([2, 3, 4, 5]), b"number 7"))

    def test_frames_of_edgesink_are_retained_messages(self):
        _, messages = self.client("edge/inference/+/objects/#")
        self.send(self.edge("edgesink sync=false", "MQTT"))
        for frame in FRAMES:
            message = messages.get(timeout=SECONDS)
            self.assertEqual(edge_peer.decode_mqtt(message.payload), (2080, [frame], []))
            self.assertRegex(message.topic, r"^edge/inference/device-\d+/objects/$")
        self.assertEqual(messages.get(timeout=SECONDS).payload, b"")

    def test_edgesrc_reads_the_three_forms_of_mqtt(self):
        for form in edge_peer.MQTT_LAYOUTS:
            with self.subTest(form=form):
                client, _ = self.client("none")
                client.publish("edge/inference/device-1/objects/", edge_peer.encode_mqtt(form, [b"wxyz"], [["k", "v"]]), qos=1,
                               retain=True).wait_for_publish(SECONDS)
                self.assertEqual(self.received(self.edge("edgesrc", "MQTT"), 1), b"wxyz")

    def publisher(self):
        process = self.start(sys.executable, edge_peer.__file__, "publisher", "--caps", CAPS, *(frame.hex() for frame in FRAMES), text=True)
        return process.stdout.readline().split()[1]

    def test_edgesrc_finds_a_publisher_of_another_program(self):
        """One device was killed and left its address, as NNStreamer's do; the other one listens."""
        client, _ = self.client("none")
        for device, port in (("1", mqtt_broker.free_port()), ("2", self.publisher())):
            client.publish(f"edge/inference/device-{device}/objects/", f"127.0.0.1:{port}\0".encode(), qos=1,
                           retain=True).wait_for_publish(SECONDS)
        self.assertEqual(self.received(self.edge("edgesrc", "HYBRID"), len(FRAMES)), b"".join(FRAMES))

    def test_another_program_finds_edgesink(self):
        _, messages = self.client("edge/inference/+/objects/#")
        (self.folder / "in").write_bytes(b"".join(FRAMES))
        line = f"filesrc location={self.folder}/in blocksize=4 ! {CAPS} ! " + self.edge("edgesink port=0 wait-connection=true", "HYBRID")
        self.start("gst-launch-1.0", *line.split())
        address = messages.get(timeout=SECONDS).payload
        self.assertTrue(address.endswith(b"\0"))
        done = subprocess.run([sys.executable, edge_peer.__file__, "subscriber", "--connect", address[:-1].decode(), "--frames",
                               str(len(FRAMES))], capture_output=True, text=True, timeout=SECONDS)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([json.loads(text)["memories"] for text in done.stdout.splitlines()[1:]], [[frame.hex()] for frame in FRAMES])


class Npm(Peers):
    def setUp(self):
        super().setUp()
        if not shutil.which("node") or not (PEERS / "node_modules/mqtt").is_dir():
            self.skipTest("the clients of other projects are not installed: tools/setup --peers")

    def node(self, *words):
        return self.start("node", PEERS / "mqtt_client.js", self.port, *words, text=True)

    def test_it_reads_messages_of_both_versions(self):
        for version in (4, 5):
            with self.subTest(version=version):
                client = self.node("subscribe", version, f"v{version}", len(FRAMES))
                self.assertEqual(client.stdout.readline(), "subscribed\n")
                self.send(f"mqttsink port={self.port} pub-topic=v{version} mqtt-qos=1 protocol={version}")
                for number, frame in enumerate(FRAMES):
                    message = json.loads(client.stdout.readline())
                    payload = base64.b64decode(message["payload"])
                    self.assertEqual(payload[1024 if version == 4 else 0:], frame)
                    if version == 5:
                        self.assertEqual(message["user"]["seq"], str(number))
                        self.assertIn("types=(string)uint8", message["user"]["caps"])

    def test_its_messages_are_buffers(self):
        for version, payload in ((4, self.message(b"abcd")), (5, b"efgh")):
            with self.subTest(version=version):
                client = self.node("publish", version, f"v{version}", base64.b64encode(payload).decode(), CAPS)
                self.assertEqual(client.wait(SECONDS), 0)
                self.assertEqual(self.received(f"mqttsrc port={self.port} sub-topic=v{version} protocol={version}", 1), payload[-4:])


if __name__ == "__main__":
    tap_runner.main()
