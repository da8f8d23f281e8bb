// A client of grpc.health.v1 by grpc-js and grpc-health-check, for tests.
//
// node health_client.js ADDRESS [SERVICE]: prints `check STATUS`, then `watch STATUS` for each change, or `check code CODE`
// when the server has no such service; ends with its standard input.
// SPDX-License-Identifier: LGPL-2.1-or-later
'use strict';
const grpc = require('@grpc/grpc-js');
const health = require('grpc-health-check');

const [address, service] = process.argv.slice(2);
const Client = grpc.makeGenericClientConstructor(health.service, 'Health');
const client = new Client(address, grpc.credentials.createInsecure());
const request = {service: service ?? ''};

client.check(request, {deadline: Date.now() + 30000}, (error, response) => {
  console.log(error ? `check code ${error.code}` : `check ${response.status}`);
  const watched = client.watch(request);
  watched.on('data', response => console.log(`watch ${response.status}`));
  watched.on('error', error => console.log(`watch code ${error.code}`));
});
process.stdin.on('end', () => process.exit(0)).resume();
