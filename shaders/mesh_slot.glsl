// The instance of a draw of wood or leaf meshes. After the push constants.

uint slot_of_draw(uint instance) {
  return (instance & kPartBit) != 0 ? instance & ~kPartBit : wood_list[push.wood_list_first + instance];
}
