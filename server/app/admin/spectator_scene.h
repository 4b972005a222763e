// Spectator scene: what viewers are told once: types, zones, doors and platforms as JSON, geometry
// in pieces.
#pragma once

#include "server/config/settings.h"

#include <cstdint>
#include <string>

namespace zoned::app {

/// The largest piece, bytes, but for one row of heights that is longer.
inline constexpr std::size_t kPieceBytes = 262144;

/// As server/admin/viewer/renderer.js reads it: world, tick rate, ground, types, zones, doors,
/// platforms, surfaces, and how many pieces of geometry there are. `recorded`: last tick of the
/// recording that is shown; 0: none is.
[[nodiscard]] std::string scene_json(const config::Settings& settings, Tick recorded = 0);

/// Facts of the world for the page /play, beside what the server tells every client: what it is
/// called, how types look, the surfaces of soft ones that clients deform, and where the WebSocket
/// is (0: nowhere).
[[nodiscard]] std::string play_json(const config::Settings& settings,
                                    std::uint16_t websocket_port,
                                    bool websocket_tls);

/// Piece `number`, from 1 on; empty where there is none. Little-endian, with the head u32 kind,
/// u32 owner, u32 first, u32 count:
/// 1 boxes: `count` times f32 centre x, y, z, half sizes x, y, z, orientation x, y, z, w.
/// 2 triangles of type `owner`, in its body's axes: 9 f32 each.
/// 3 heights of surface `owner`: `count` rows from row `first` on, f32 each.
/// 4 vertices of surface `owner`: 3 f32 each, from vertex `first` on.
/// 5 triangles of surface `owner`: 3 u32 each, from triangle `first` on.
[[nodiscard]] std::string scene_piece(const config::Settings& settings, std::uint32_t number);

}  // namespace zoned::app
