// Snow, as an engine adds it to its plants' surfaces. parameters.x: how much lies, 0 to 1
void coppice_engine_surface(inout CoppiceSurface surface, CoppiceSurfacePlace place) {
  float lies = place.parameters.x * smoothstep(0.0, 0.6, place.is_wood ? surface.normal.y : abs(surface.normal.y));
  surface.albedo = mix(surface.albedo, vec3(0.9), lies);
  surface.roughness = mix(surface.roughness, 0.7, lies);
  surface.translucency *= 1.0 - lies;
}
