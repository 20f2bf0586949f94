#ifndef COPPICE_H
#define COPPICE_H

/* libcoppice streams level of detail for plants. This header needs no graphics API. It declares hooks, the context, plants, instances,
 * scenes, views, streaming and statistics. Two libraries implement it: libcoppice, for hosts that draw themselves, and libcoppice_vulkan,
 * which adds our renderer on the engine's Vulkan device (coppice/vulkan.h). A program links one of them.
 *
 * A host creates a context, and one view for each picture. It opens plants and adds instances, or it opens a scene, which does both. In
 * each frame it says what its cameras show:
 *
 *     coppice_frame_begin(context, &frame);   frame_number grows; completed_number is the last frame that the GPU has finished, for
 *                                             example the last one whose fence has signalled
 *     ...                                     with our renderer: upload, cull, draw (coppice/vulkan.h); else changes and draws (below)
 *
 * It repeats this until coppice_is_settled, or for as long as it runs. A frame lasts until the next coppice_frame_begin. Functions that
 * change plants, instances, scenes, views or the origin are called before coppice_record_upload (without a renderer: before
 * coppice_frame_begin), or after the last call of the frame that records or asks for draws.
 *
 * Units and axes: metres, right-handed, +Y up, as in glTF. Matrices are column-major, for column vectors. View space looks down -Z. Clip
 * space is Vulkan's: y points down, depth runs from 0 to 1. Booleans are uint32_t: COPPICE_FALSE or COPPICE_TRUE, no other value.
 *
 * Words:
 *   leaf, wood     a plant consists of leaves, quads that merge into larger ones, and of wood, a mesh in several levels of detail (LoDs)
 *   cut            a set of quads that together show the whole plant, with any number of leaves from all to 1, the root
 *   page           512 steps of refinement, 1,024 quads. Pages arrive in order: the resident ones are a prefix, and a complete plant
 *   leaf mesh      leaves as they were modelled; they replace quads close up
 *   chunk          the unit of reading and eviction: a page, a wood LoD, a texture, a part of the leaf meshes
 *   front          the first part of a file: tables, the coarsest wood, the first page. It is enough for a first picture
 *   threshold      the error that an instance may have in a view, px (coppice_camera.error_px)
 *   tile, species  a tile is a square of a scene with up to 2,048 plants, loaded together; a species is a plant that a scene names
 *   resident       in memory, ready to be drawn
 *   settled        everything that is in demand and fits is resident
 *   view group     views whose demand is measured together, at one threshold (coppice_frame_begin)
 *
 * Threads: distinct contexts are independent. Calls on one context are externally serialised. Functions that take a const context may
 * overlap with each other, and so may the recording of different views (coppice/vulkan.h). The comment of a hook says which threads call
 * it. A library that was built without NDEBUG, or with _GLIBCXX_ASSERTIONS, refuses calls that overlap and calls from inside a hook: it
 * returns COPPICE_ERROR_INVALID_ARGUMENT and logs a line.
 *
 * Errors: every function that can fail returns a coppice_status, also in release builds. The log hook gets one line that names the field
 * and its index: "coppice_instances_add: placements[3].position[0] is not finite". coppice_last_error returns the last such line. A call
 * that is refused changes nothing. A null context, or a null pointer where none is allowed, is COPPICE_ERROR_INVALID_ARGUMENT. No exception
 * leaves the library.
 *
 * Comments of functions state these points, in this order. A point that is missing means:
 *   before   the function may be called at any time, between frames or within one
 *   after    nothing else has changed
 *   queue    none; only functions of coppice/vulkan.h that take a command buffer have one
 *   thread   any, one call at a time on a context
 *   cost     microseconds; the call does not wait for files, jobs or the GPU
 *   errors   COPPICE_ERROR_INVALID_ARGUMENT alone
 *
 * Structs grow: later versions add fields at the end. A struct that is no element of an array starts with struct_size, its size in the
 * header that the program was compiled with. The *_init function sets it, and every other field to its default; it does nothing for a null
 * pointer. A program therefore runs with later versions of the library. It runs with earlier ones too if it leaves the fields that they do
 * not know at 0:
 *   structs that the library reads   fields that a smaller struct lacks have their defaults. A larger struct is accepted if the bytes that
 *                                    this version does not know are all 0; else COPPICE_ERROR_INVALID_ARGUMENT, and the log names the byte
 *   structs that the library fills   a smaller struct is filled as far as it goes; the rest of a larger one becomes 0
 *   structs that a hook is given     struct_size says how large it is; a program must not read further
 * Sizes are multiples of 4 from 4 to 4,096 bytes; others are COPPICE_ERROR_INVALID_ARGUMENT. Enumerations grow too: expect values that you
 * do not know. */

/* base.h: version, errors, structs that grow, handles. hooks.h: an engine's memory, jobs, files, log and trace. context.h: context, plants,
 * instances. scene.h: scenes, picking. frame.h: views, frames, statistics. host.h: changes and draws, for hosts that draw themselves. */
#include <coppice/base.h>
#include <coppice/context.h>
#include <coppice/frame.h>
#include <coppice/hooks.h>
#include <coppice/host.h>
#include <coppice/scene.h>

#endif
