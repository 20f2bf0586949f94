// The contents of a view's attachments. After bindings.glsl.

#ifndef COPPICE_CONTENTS_GLSL
#define COPPICE_CONTENTS_GLSL

// Content of each attachment, in kContentBits, the first in the lowest: kContent of coppice_shared.h. 0: only depth.
layout(constant_id = 7) const uint kContents = kContentLit;

bool has_content(uint content) {
  return (kContents & 15u) == content || (kContents >> 4 & 15u) == content || (kContents >> 8 & 15u) == content ||
         (kContents >> 12 & 15u) == content || (kContents >> 16 & 15u) == content || (kContents >> 20 & 15u) == content ||
         (kContents >> 24 & 15u) == content || kContents >> 28 == content;
}

#endif
