// Messages and descriptors between two processes: a pair of sockets that keep messages apart (SOCK_SEQPACKET). What
// comes in is not believed: a message that is too long, or that has other descriptors than asked for, is none.
#pragma once

#include <chrono>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/control.h"
#include "server/sandbox/descriptor.h"

namespace meshgauge::server::sandbox {

inline constexpr std::chrono::milliseconds kTick{10};  // how often one who waits asks whether to go on
inline constexpr std::size_t kMaxMessageBytes = std::size_t{16} << 10;

struct Channel {
  Descriptor ours;
  Descriptor theirs;
};

std::optional<Channel> open_channel();  // both ends are closed on exec; nullopt: no descriptors are left

struct Message {
  std::string bytes;
  std::vector<Descriptor> files;
};

// At most two files, which stay the caller's. False when the other end is closed or its buffer is full; never waits.
bool send_message(int socket, std::string_view bytes, std::initializer_list<int> files = {});

// Waits at most `time` until a message can be received, or nothing will come any more.
bool readable(int socket, std::chrono::milliseconds time);

// The same, but ends, with false, within kTick when `interrupted` says so.
bool readable(int socket, std::chrono::milliseconds time, const Interrupted& interrupted);

// The other end is closed, by its process or with it, or will be within kTick. What it sent before may still be
// received.
bool closed(int socket);

// Waits. nullopt: the other end is closed (or sent an empty message), or what came does not fit or has not exactly
// `files` descriptors, of which there are at most two. With `files` 0 whatever is sent along never enters this process.
std::optional<Message> receive_message(int socket, std::size_t files);

}  // namespace meshgauge::server::sandbox
