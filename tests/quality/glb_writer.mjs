// A binary glTF file, piece by piece: for the scripts that make plants out of packages.

const kFloat = 5126, kUnsignedInt = 5125, kVertices = 34962, kIndices = 34963;

/** An sRGB value, 0..1. */
export const linear = value => value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;

export class GlbWriter {
  chunks = [];
  bytes = 0;
  json = {asset: {version: '2.0'}, scene: 0, scenes: [{nodes: []}], nodes: [], meshes: [], materials: [], accessors: [], bufferViews: []};

  view(data, target) {
    const buffer = Buffer.from(data.buffer ?? data, data.byteOffset ?? 0, data.byteLength ?? data.length);
    this.json.bufferViews.push({buffer: 0, byteOffset: this.bytes, byteLength: buffer.length, ...(target && {target})});
    const padding = Buffer.alloc((4 - buffer.length % 4) % 4);
    this.chunks.push(buffer, padding);
    this.bytes += buffer.length + padding.length;
    return this.json.bufferViews.length - 1;
  }

  floats(values, width) {
    const accessor = {bufferView: this.view(new Float32Array(values), kVertices), componentType: kFloat, count: values.length / width,
                      type: `VEC${width}`};
    if (width === 3) {
      accessor.min = [Infinity, Infinity, Infinity], accessor.max = [-Infinity, -Infinity, -Infinity];
      for (let i = 0; i < values.length; ++i) {
        const value = Math.fround(values[i]);
        accessor.min[i % 3] = Math.min(accessor.min[i % 3], value), accessor.max[i % 3] = Math.max(accessor.max[i % 3], value);
      }
    }
    return this.json.accessors.push(accessor) - 1;
  }

  indices(values) {
    const bufferView = this.view(new Uint32Array(values), kIndices);
    return this.json.accessors.push({bufferView, componentType: kUnsignedInt, count: values.length, type: 'SCALAR'}) - 1;
  }

  /** The number of a texture of this image file's bytes. */
  texture(name, bytes) {
    const {json} = this;
    json.images ??= [], json.textures ??= [];
    const found = json.images.findIndex(image => image.name === name);
    if (found >= 0) return found;
    const mimeType = bytes[0] === 0x89 ? 'image/png' : 'image/jpeg';
    json.images.push({name, mimeType, bufferView: this.view(bytes)});
    return json.textures.push({source: json.images.length - 1}) - 1;
  }

  mesh(name, material, {indices, positions, normals, uvs}) {
    const attributes = {POSITION: this.floats(positions, 3), TEXCOORD_0: this.floats(uvs, 2)};
    if (normals) attributes.NORMAL = this.floats(normals, 3);
    const mesh = this.json.meshes.push({name, primitives: [{attributes, indices: this.indices(indices), material, mode: 4}]}) - 1;
    this.json.scenes[0].nodes.push(this.json.nodes.push({name, mesh}) - 1);
  }

  file() {
    this.json.buffers = [{byteLength: this.bytes}];
    const text = Buffer.from(JSON.stringify(this.json)), json = Buffer.concat([text, Buffer.alloc((4 - text.length % 4) % 4, ' ')]);
    const head = Buffer.alloc(20), between = Buffer.alloc(8);
    head.write('glTF'), head.writeUInt32LE(2, 4), head.writeUInt32LE(28 + json.length + this.bytes, 8);
    head.writeUInt32LE(json.length, 12), head.write('JSON', 16);
    between.writeUInt32LE(this.bytes, 0), between.write('BIN\0', 4);
    return Buffer.concat([head, json, between, ...this.chunks]);
  }
}
