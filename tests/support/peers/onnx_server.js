// An inference server of grpc-js and onnxruntime-node, for tests: another HTTP/2, another protobuf and another
// program around ONNX Runtime than the client's.
//
// node onnx_server.js inference.proto NAME=MODEL.onnx...; prints `port PORT` when it listens, and ends with its
// standard input.
// SPDX-License-Identifier: LGPL-2.1-or-later
'use strict';
const grpc = require('@grpc/grpc-js');
const loader = require('@grpc/proto-loader');
const ort = require('onnxruntime-node');

// The types of ONNX Runtime that the tests use: the protocol's name and the array of a tensor.
const TYPES = {
  float32: ['FP32', Float32Array],
  uint8: ['UINT8', Uint8Array],
  int32: ['INT32', Int32Array],
};

function fail(code, details) {
  return Object.assign(new Error(details), {code, details});
}

function describe(metadata) {
  return metadata.map(
      tensor => ({
        name: tensor.name,
        datatype: TYPES[tensor.type][0],
        shape: tensor.shape.map(extent => typeof extent === 'number' ? extent : -1),
      }));
}

class Server {
  constructor(sessions) {
    this.sessions = sessions;
  }

  session(name) {
    const found = this.sessions.get(name);
    if (!found) throw fail(grpc.status.NOT_FOUND, `there is no model ${name}`);
    return found;
  }

  ServerReady() {
    return {ready: true};
  }

  ModelReady(request) {
    return {ready: this.sessions.has(request.name)};
  }

  ModelMetadata(request) {
    const session = this.session(request.name);
    return {
      name: request.name,
      versions: ['1'],
      platform: 'onnx',
      inputs: describe(session.inputMetadata),
      outputs: describe(session.outputMetadata),
    };
  }

  async ModelInfer(request) {
    const session = this.session(request.model_name);
    const feeds = {};
    request.inputs.forEach((input, i) => {
      const known = session.inputMetadata.find(tensor => tensor.name === input.name);
      if (!known) throw fail(grpc.status.INVALID_ARGUMENT, `the model has no input ${input.name}`);
      const [datatype, Elements] = TYPES[known.type];
      if (input.datatype !== datatype)
        throw fail(grpc.status.INVALID_ARGUMENT, `${input.name} is ${datatype}, not ${input.datatype}`);
      const raw = request.raw_input_contents[i];
      if (!raw) throw fail(grpc.status.INVALID_ARGUMENT, 'only raw contents are known here');
      const bytes = Uint8Array.from(raw);  // at an address that suits the elements
      feeds[input.name] = new ort.Tensor(known.type, new Elements(bytes.buffer), input.shape.map(Number));
    });
    const results = await session.run(feeds);
    const outputs = session.outputMetadata.map(tensor => [tensor, results[tensor.name]]);
    return {
      model_name: request.model_name,
      model_version: '1',
      id: request.id,
      outputs: outputs.map(
          ([tensor, result]) => ({name: tensor.name, datatype: TYPES[tensor.type][0], shape: result.dims})),
      raw_output_contents: outputs.map(
          ([, result]) => Buffer.from(result.data.buffer, result.data.byteOffset, result.data.byteLength)),
    };
  }
}

async function main([proto, ...models]) {
  const sessions = new Map();
  for (const model of models) {
    const [name, file] = model.split('=');
    sessions.set(name, await ort.InferenceSession.create(file, {intraOpNumThreads: 1}));
  }
  const service = grpc.loadPackageDefinition(loader.loadSync(proto, {keepCase: true, defaults: true}))
                      .inference.GRPCInferenceService.service;
  const own = new Server(sessions);
  const handlers = {};
  for (const name of ['ServerReady', 'ModelReady', 'ModelMetadata', 'ModelInfer'])
    handlers[name] = (call, done) => {
      Promise.resolve()
          .then(() => own[name](call.request))
          .then(
              response => done(null, response),
              error => done(error.code === undefined ? fail(grpc.status.INTERNAL, String(error)) : error));
    };
  const server = new grpc.Server({'grpc.max_receive_message_length': -1, 'grpc.max_send_message_length': -1});
  server.addService(service, handlers);
  server.bindAsync('127.0.0.1:0', grpc.ServerCredentials.createInsecure(), (error, port) => {
    if (error) throw error;
    console.log(`port ${port}`);
  });
  process.stdin.on('end', () => process.exit(0)).resume();
}

main(process.argv.slice(2));
