// meshopt_levels.mjs PACKAGE QUADS.glb FOLDER [FRACTIONS]
//
// Levels of meshoptimizer's npm package (its current release, where Debian's library is of 2022) for `coppice evaluate --levels-of`: a folder
// for each choice of its options, in it a file for each level. QUADS.glb is what `coppice evaluate --write-source` wrote; a level of fraction f
// of N leaves has at most 2 floor(f N) triangles. fetch_meshopt fetches and checks the package.

import fs from 'node:fs';
import path from 'node:path';

import {GlbWriter} from './glb_writer.mjs';

const [, , folder, input, output, list = '0.8,0.6,0.4,0.2,0.1,0.05,0.025'] = process.argv;
const {MeshoptSimplifier: simplifier} = await import(path.resolve(folder, 'meshopt_simplifier.js'));
await simplifier.ready;

/** The file's JSON and what its views hold. */
function read(file) {
  const bytes = fs.readFileSync(file), length = bytes.readUInt32LE(12), json = JSON.parse(bytes.subarray(20, 20 + length));
  const view = ({byteOffset = 0, byteLength}) => bytes.subarray(28 + length + byteOffset, 28 + length + byteOffset + byteLength);
  const array = index => {
    const {bufferView, byteOffset = 0, componentType, count, type} = json.accessors[index];
    const buffer = Uint8Array.from(view(json.bufferViews[bufferView])).buffer, width = {SCALAR: 1, VEC2: 2, VEC3: 3}[type];
    return new {5126: Float32Array, 5125: Uint32Array, 5123: Uint16Array}[componentType](buffer, byteOffset, count * width);
  };
  return {json, array, image: index => view(json.bufferViews[json.images[index].bufferView])};
}

/** All leaves as one mesh whose vertices know their material. */
function join({json, array}) {
  const mesh = {indices: [], positions: [], normals: [], uvs: [], materials: []};
  for (const {attributes, indices, material} of json.meshes.flatMap(each => each.primitives)) {
    const first = mesh.materials.length, positions = array(attributes.POSITION);
    for (const index of array(indices)) mesh.indices.push(first + index);
    for (const [name, to] of [['POSITION', 'positions'], ['NORMAL', 'normals'], ['TEXCOORD_0', 'uvs']])
      for (const value of array(attributes[name])) mesh[to].push(value);
    for (let i = 0; i < positions.length / 3; ++i) mesh.materials.push(material);
  }
  return {indices: new Uint32Array(mesh.indices), positions: new Float32Array(mesh.positions), normals: new Float32Array(mesh.normals),
          uvs: mesh.uvs, materials: mesh.materials};
}

const kAnyError = 1;

/** The largest of `values`, ascending, at which make(value) has at most `most` indices, and what it made; the first if none has. */
function finest(values, most, make) {
  let low = 0, high = values.length - 1;
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (make(values[middle]).length <= most) low = middle; else high = middle - 1;
  }
  return make(values[low]);
}

// Each gives a mesh's indices, or a mesh of its own, with at most so many indices.
const plain = (...flags) => (mesh, count) => ({indices: simplifier.simplify(mesh.indices, mesh.positions, 3, count, kAnyError, flags)[0]});
const weighed = (weight, ...flags) => (mesh, count) => ({
  indices: simplifier.simplifyWithAttributes(mesh.indices, mesh.positions, 3, mesh.normals, 3, [weight, weight, weight], null, count,
                                             kAnyError, flags)[0]});
const updated = (weight, ...flags) => (mesh, count) => {
  const indices = mesh.indices.slice(), positions = mesh.positions.slice(), normals = mesh.normals.slice();
  const [length] = simplifier.simplifyWithUpdate(indices, positions, 3, normals, 3, [weight, weight, weight], null, count, kAnyError, flags);
  return {indices: indices.subarray(0, length), positions, normals};
};
const sloppy = (mesh, count) => ({indices: simplifier.simplifySloppy(mesh.indices, mesh.positions, 3, null, count, kAnyError)[0]});
const pruned = (mesh, count) => {
  const errors = Array.from({length: 64}, (_, i) => 2 ** ((i - 63) / 4)).reverse();  // from all pruned to nearly none
  return {indices: finest(errors, count, error => simplifier.simplifyPrune(mesh.indices, mesh.positions, 3, error))};
};
const remeshed = (mesh, count) => {
  const soup = finest(Array.from({length: 64}, (_, i) => 2 + 2 * i), 3 * count,
                      resolution => simplifier.remesh(mesh.indices, mesh.positions, 3, resolution, []));
  const indices = Uint32Array.from({length: soup.length / 3}, (_, i) => i);
  return {indices, positions: soup, normals: new Float32Array(soup.length).fill(Math.sqrt(1 / 3)), uvs: new Array(indices.length * 2).fill(0),
          materials: new Array(indices.length).fill(mesh.materials[0])};
};

const variants = {
  plain: plain(), prune: plain('Prune'), permissive: plain('Permissive'), prune_permissive: plain('Prune', 'Permissive'),
  prune_regularize: plain('Prune', 'Regularize'), prune_folds: plain('Prune', 'PreserveFolds'),
  normals: weighed(0.5), normals_prune: weighed(0.5, 'Prune'), normals_prune_permissive: weighed(0.5, 'Prune', 'Permissive'),
  heavy_normals_prune: weighed(2, 'Prune'), update_prune: updated(0.5, 'Prune'),
  update_prune_permissive: updated(0.5, 'Prune', 'Permissive'), sloppy, prune_by_size: pruned, remesh: remeshed,
};

/** A mesh a material, of the vertices that triangles use. A triangle shows its first corner's. */
function write(file, source, mesh) {
  const writer = new GlbWriter();
  for (let i = 0; i < (source.json.images ?? []).length; ++i) writer.texture(`image ${i}`, source.image(i));
  writer.json.materials = source.json.materials;
  if (writer.json.textures) writer.json.textures = source.json.textures.map(({source: image}) => ({source: image}));
  const {indices} = mesh;
  for (const material of new Set(mesh.materials)) {
    const part = {indices: [], positions: [], normals: [], uvs: []}, places = new Map();
    for (let t = 0; t < indices.length; t += 3) {
      if (mesh.materials[indices[t]] !== material) continue;
      for (const index of indices.slice(t, t + 3)) {
        if (!places.has(index)) {
          places.set(index, places.size);
          for (const [name, width] of [['positions', 3], ['normals', 3], ['uvs', 2]])
            for (let i = 0; i < width; ++i) part[name].push(mesh[name][width * index + i]);
        }
        part.indices.push(places.get(index));
      }
    }
    if (part.indices.length > 0) writer.mesh(`leaves ${material}`, material, part);
  }
  fs.writeFileSync(file, writer.file());
}

const source = read(input), mesh = join(source), leaves = mesh.indices.length / 6;
for (const [name, simplify] of Object.entries(variants)) {
  fs.mkdirSync(path.join(output, name), {recursive: true});
  for (const fraction of list.split(',').map(Number)) {
    const count = 6 * Math.max(1, Math.floor(fraction * leaves + 1e-6));
    const simple = simplify(mesh, count);
    // A file without triangles is not a plant: where nothing is left, one triangle is.
    if (simple.indices.length === 0) simple.indices = mesh.indices.slice(0, 3);
    write(path.join(output, name, `${fraction}.glb`), source, {...mesh, ...simple});
  }
}
