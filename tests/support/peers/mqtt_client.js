// A client of MQTT brokers by mqtt of npm, for tests: another implementation of MQTT 3.1.1 and 5.
//
//   node mqtt_client.js PORT subscribe VERSION TOPIC COUNT   prints `subscribed`, then each message as a line of JSON
//   node mqtt_client.js PORT publish VERSION TOPIC BASE64 CAPS   publishes a retained message
// SPDX-License-Identifier: LGPL-2.1-or-later
'use strict';

const mqtt = require('mqtt');

const [port, what, version, topic, ...rest] = process.argv.slice(2);
const client = mqtt.connect(`mqtt://127.0.0.1:${port}`, {protocolVersion: Number(version)});

function fail(error) {
  console.error(error.message);
  process.exit(1);
}

function subscribe() {
  let left = Number(rest[0]);
  client.on('message', (at, payload, packet) => {
    const user = packet.properties && packet.properties.userProperties;
    console.log(JSON.stringify({topic: at, payload: payload.toString('base64'), retain: packet.retain, user}));
    if (--left === 0) client.end();
  });
  client.subscribe(topic, {qos: 1}, (error) => error ? fail(error) : console.log('subscribed'));
}

function publish() {
  const userProperties = {caps: rest[1], 'base-epoch': '1', seq: '0', 'sent-epoch': '4611686018427387904'};
  const properties = Number(version) === 5 ? {userProperties} : undefined;
  client.publish(topic, Buffer.from(rest[0], 'base64'), {qos: 1, retain: true, properties},
                 (error) => error ? fail(error) : client.end());
}

client.on('error', fail);
client.on('connect', what === 'subscribe' ? subscribe : publish);
