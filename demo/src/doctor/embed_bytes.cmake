# Turns a file into an array of bytes:  cmake -DINPUT=hazel.coppice -DOUTPUT=hazel.h -DNAME=kHazel -P embed_bytes.cmake
file(READ ${INPUT} bytes HEX)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
string(REGEX REPLACE "(0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,)" "\\1\n" bytes "${bytes}")
file(WRITE ${OUTPUT} "// Written by embed_bytes.cmake.\n#pragma once\n\nalignas(8) inline constexpr unsigned char ${NAME}[] = {\n${bytes}};\n")
