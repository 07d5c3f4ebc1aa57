#include "server/sandbox/channel.h"

#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>

namespace meshgauge::server::sandbox {
namespace {

constexpr std::size_t kMostFiles = 2;

// Buffer for the descriptors of a message.
struct Along {
  alignas(cmsghdr) char bytes[CMSG_SPACE(kMostFiles * sizeof(int))] = {};
};

void attach(msghdr& header, Along& along, std::initializer_list<int> files) {
  const std::size_t size = files.size() * sizeof(int);
  header.msg_control = along.bytes;
  header.msg_controllen = CMSG_SPACE(size);
  cmsghdr* const control = CMSG_FIRSTHDR(&header);
  control->cmsg_level = SOL_SOCKET;
  control->cmsg_type = SCM_RIGHTS;
  control->cmsg_len = CMSG_LEN(size);
  std::memcpy(CMSG_DATA(control), files.begin(), size);
}

std::vector<Descriptor> detach(msghdr& header) {
  std::vector<Descriptor> files;
  for (cmsghdr* control = CMSG_FIRSTHDR(&header); control != nullptr; control = CMSG_NXTHDR(&header, control)) {
    if (control->cmsg_level != SOL_SOCKET || control->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (control->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(control) + i * sizeof fd, sizeof fd);
      files.emplace_back(fd);
    }
  }
  return files;
}

}  // namespace

std::optional<Channel> open_channel() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return std::nullopt;
  return Channel{Descriptor(ends[0]), Descriptor(ends[1])};
}

bool send_message(int socket, std::string_view bytes, std::initializer_list<int> files) {
  if (bytes.size() > kMaxMessageBytes) return false;
  iovec text{const_cast<char*>(bytes.data()), bytes.size()};
  msghdr header{};
  header.msg_iov = &text;
  header.msg_iovlen = 1;
  Along along;
  if (files.size() > 0) attach(header, along, files);
  ssize_t sent = -1;
  do {
    sent = ::sendmsg(socket, &header, MSG_NOSIGNAL | MSG_DONTWAIT);
  } while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(bytes.size());
}

bool readable(int socket, std::chrono::milliseconds time) {
  pollfd wait{socket, POLLIN, 0};
  int ready = -1;
  do {
    ready = ::poll(&wait, 1, static_cast<int>(time.count()));
  } while (ready < 0 && errno == EINTR);
  return ready > 0;
}

bool readable(int socket, std::chrono::milliseconds time, const Interrupted& interrupted) {
  const auto end = Control::Clock::now() + time;
  while (!readable(socket, kTick)) {
    if (interrupted() || Control::Clock::now() >= end) return false;
  }
  return true;
}

bool closed(int socket) {
  pollfd look{socket, 0, 0};
  return ::poll(&look, 1, kTick.count()) > 0 && (look.revents & POLLHUP) != 0;
}

std::optional<Message> receive_message(int socket, std::size_t files) {
  Message message;
  message.bytes.resize(kMaxMessageBytes);
  iovec text{message.bytes.data(), message.bytes.size()};
  msghdr header{};
  header.msg_iov = &text;
  header.msg_iovlen = 1;
  Along along;
  if (files > 0) {
    header.msg_control = along.bytes;
    header.msg_controllen = sizeof along.bytes;
  }
  ssize_t received = -1;
  do {
    received = ::recvmsg(socket, &header, MSG_CMSG_CLOEXEC);
  } while (received < 0 && errno == EINTR);
  if (received <= 0) return std::nullopt;
  message.bytes.resize(static_cast<std::size_t>(received));
  if (files > 0) message.files = detach(header);
  if ((header.msg_flags & MSG_TRUNC) != 0 || message.files.size() != files) return std::nullopt;
  return message;
}

}  // namespace meshgauge::server::sandbox
