// obj_to_glb.mjs IN.obj OUT.glb COPYRIGHT
//
// A Wavefront OBJ with its MTL as a binary glTF file: what `fetch_plants` needs of that format, and no more. Triangles keep the order of the
// faces, one mesh a material; polygons become fans. Diffuse colours are taken for sRGB; a material with an image is white, and one whose image is
// missing has its colour.

import fs from 'node:fs';
import path from 'node:path';

import {GlbWriter, linear} from './glb_writer.mjs';

/** [{name, image, color, opacity}] in the order of the file. */
function readMaterials(file) {
  const materials = [];
  for (const line of fs.readFileSync(file, 'latin1').split(/\r?\n/)) {
    const [key, ...values] = line.trim().split(/\s+/);
    if (key === 'newmtl') materials.push({name: values.join(' '), color: [1, 1, 1], opacity: 1});
    const material = materials.at(-1);
    if (key === 'Kd') material.color = values.map(Number);
    if (key === 'd') material.opacity = Number(values[0]);
    if (key === 'map_Kd') material.image = values.at(-1);
  }
  return materials;
}

/** The faces of each material, by name: corners as [position, uv, normal] of the lists in `attributes`, or NaN. */
function readFaces(file) {
  const attributes = {v: [], vt: [], vn: []}, faces = new Map();
  let current = '', library = '';
  for (const line of fs.readFileSync(file, 'latin1').split(/\r?\n/)) {
    const [key, ...values] = line.trim().split(/\s+/);
    if (key in attributes) attributes[key].push(values.map(Number));
    if (key === 'usemtl') current = values.join(' ');
    if (key === 'mtllib') library = values.join(' ');
    if (key !== 'f') continue;
    const counts = [attributes.v.length, attributes.vt.length, attributes.vn.length];
    const corners = values.map(corner => corner.split('/').map((text, i) => Number(text) < 0 ? counts[i] + Number(text) : Number(text) - 1));
    if (!faces.has(current)) faces.set(current, []);
    for (let i = 2; i < corners.length; ++i) faces.get(current).push(corners[0], corners[i - 1], corners[i]);
  }
  return {attributes, faces, library};
}

/** Corners as vertices, equal ones once. */
function indexCorners(corners, attributes) {
  const numbers = new Map(), indices = [], positions = [], normals = [], uvs = [];
  for (const [position, uv, normal] of corners) {
    const key = `${position}/${uv}/${normal}`;
    if (!numbers.has(key)) {
      numbers.set(key, numbers.size);
      positions.push(...attributes.v[position].slice(0, 3));
      if (attributes.vn[normal]) normals.push(...attributes.vn[normal]);
      const [u, v] = attributes.vt[uv] ?? [0, 0];
      uvs.push(u, 1 - v);
    }
    indices.push(numbers.get(key));
  }
  return {indices, positions, normals: normals.length === positions.length ? normals : null, uvs};
}

function addMaterial(writer, material, folder) {
  const made = {name: material.name, doubleSided: true, pbrMetallicRoughness: {roughnessFactor: 0.9, metallicFactor: 0}};
  if (material.image && fs.existsSync(path.join(folder, material.image))) {
    const bytes = fs.readFileSync(path.join(folder, material.image));
    made.pbrMetallicRoughness.baseColorTexture = {index: writer.texture(material.image, bytes)};
    // A PNG of grey and alpha or of RGBA cuts holes.
    if (bytes[0] === 0x89 && (bytes[25] & 4) !== 0) made.alphaMode = 'MASK';
  } else {
    made.pbrMetallicRoughness.baseColorFactor = [...material.color.map(linear), 1];
  }
  return writer.json.materials.push(made) - 1;
}

const [, , input, output, copyright] = process.argv;
const folder = path.dirname(input), {attributes, faces, library} = readFaces(input), writer = new GlbWriter();
writer.json.asset.copyright = copyright;
const materials = new Map(readMaterials(path.join(folder, library)).map(material => [material.name, material]));
for (const [name, corners] of faces) {
  const material = addMaterial(writer, materials.get(name) ?? {name, color: [1, 1, 1]}, folder);
  writer.mesh(name, material, indexCorners(corners, attributes));
}
fs.writeFileSync(output, writer.file());
