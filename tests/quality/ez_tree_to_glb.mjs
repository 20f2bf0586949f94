// ez_tree_to_glb.mjs NODE_MODULES PRESET OUT.glb COPYRIGHT
//
// A tree of the npm package @dgreenheck/ez-tree, grown from one of its presets, as a binary glTF file. Wind and shaders are left
// out.

import fs from 'node:fs';
import path from 'node:path';

import {GlbWriter, linear} from './glb_writer.mjs';

const [, , modules, preset, output, copyright] = process.argv;
// The package loads its textures when it is imported, as a page would. Nobody looks at them here.
globalThis.document = {createElementNS: () => ({addEventListener() {}, removeEventListener() {}, set src(_) {}})};
const {Tree} = await import(path.resolve(modules, '@dgreenheck/ez-tree/build/ez-tree.es.js'));
const assets = path.join(modules, '@dgreenheck/ez-tree/src/lib/assets');

function addMaterial(writer, name, image, tint, cutoff) {
  const color = [16, 8, 0].map(shift => linear((tint >> shift & 255) / 255));
  const texture = writer.texture(path.basename(image), fs.readFileSync(path.join(assets, image)));
  const look = {baseColorFactor: [...color, 1], metallicFactor: 0, roughnessFactor: 0.9, baseColorTexture: {index: texture}};
  const made = {name, pbrMetallicRoughness: look, ...(cutoff && {alphaMode: 'MASK', alphaCutoff: cutoff, doubleSided: true})};
  return writer.json.materials.push(made) - 1;
}

/** What a mesh has, with its image repeated x times along u and 1 / y times along v. three.js counts v from the image's lower edge. */
const arrays = ({attributes, index}, {x, y} = {x: 1, y: 1}) => ({indices: index.array, positions: attributes.position.array,
                                                                 normals: attributes.normal.array,
                                                                 uvs: attributes.uv.array.map((t, i) => i % 2 === 0 ? t * x : 1 - t / y)});

const tree = new Tree();
tree.loadPreset(preset);
const {bark, leaves} = tree.options, writer = new GlbWriter();
writer.json.asset.copyright = copyright;
const barkMaterial = addMaterial(writer, 'branches', `bark/${bark.type}_color_1k.jpg`, bark.tint);
const leafMaterial = addMaterial(writer, 'leaves', `leaves/${leaves.type}_color.png`, leaves.tint, leaves.alphaTest);
writer.mesh('branches', barkMaterial, arrays(tree.branchesMesh.geometry, bark.textureScale));
writer.mesh('leaves', leafMaterial, arrays(tree.leavesMesh.geometry));
fs.writeFileSync(output, writer.file());
