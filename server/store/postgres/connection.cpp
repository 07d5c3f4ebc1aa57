#include "server/store/postgres/connection.h"

#include <poll.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cerrno>

#include <libpq-fe.h>

namespace meshgauge::server::store {
namespace {

// PostgreSQL's numbers of its types (pg_type.dat), which never change.
constexpr unsigned kBool = 16, kBytea = 17, kInt8 = 20, kInt2 = 21, kInt4 = 23, kFloat8 = 701;
constexpr unsigned kByteaArray = 1001, kInt8Array = 1016, kFloat8Array = 1022;

template <class Unsigned>
void append(std::string& bytes, Unsigned number) {
  for (int shift = static_cast<int>(sizeof(number)) * 8 - 8; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<char>((number >> shift) & 0xff));
  }
}

std::uint64_t read_number(std::string_view bytes) {
  std::uint64_t number = 0;
  for (const char c : bytes) number = number << 8 | static_cast<unsigned char>(c);
  return number;
}

std::string bytes_of(std::int64_t number) {
  std::string bytes;
  append(bytes, static_cast<std::uint64_t>(number));
  return bytes;
}
std::string bytes_of(double real) { return bytes_of(std::bit_cast<std::int64_t>(real)); }
const std::string& bytes_of(const std::string& text) { return text; }

template <class T>
const T* value_of(const std::optional<T>& value) {
  return value ? &*value : nullptr;
}
template <class T>
const T* value_of(const T& value) {
  return &value;
}

// Number of dimensions, flag for nulls, type; length and lower bound of the dimension; then each element after its
// length.
template <class T>
std::string array_of(unsigned type, const std::vector<T>& elements) {
  std::string bytes;
  append(bytes, std::uint32_t{1});
  append(bytes, std::uint32_t{1});
  append(bytes, static_cast<std::uint32_t>(type));
  append(bytes, static_cast<std::uint32_t>(elements.size()));
  append(bytes, std::uint32_t{1});
  for (const T& element : elements) {
    const auto* value = value_of(element);
    if (value == nullptr) {
      append(bytes, ~std::uint32_t{0});
      continue;
    }
    const std::string& sent = bytes_of(*value);
    append(bytes, static_cast<std::uint32_t>(sent.size()));
    bytes += sent;
  }
  return bytes;
}

// Defaults of the connection string: a server that is gone is noticed within seconds. libpq otherwise looks for tickets
// of Kerberos before each connection, and its library crashes where memory ends then.
constexpr std::array kDefaults = {
    std::pair("connect_timeout", "2"),     std::pair("keepalives_idle", "5"),
    std::pair("keepalives_interval", "2"), std::pair("keepalives_count", "3"),
    std::pair("tcp_user_timeout", "6000"), std::pair("fallback_application_name", "meshgauge"),
    std::pair("gssencmode", "disable"),
};

// The settings of each session. Plans must not depend on PostgreSQL's estimates of row counts: every table is read,
// joined and ordered by an index. A client that is gone must not hold locks, and waiting for a lock is short. A commit
// that is acknowledged is on the disk, and on the standby that must have it, whatever the server's default.
// `meshgauge.bounds_by` marks sessions that write bounds_by with each interval: see schema.cpp.
constexpr const char* kSession = R"sql(
SET client_min_messages = warning;
SET statement_timeout = '30s';
SET lock_timeout = '3s';
SET idle_in_transaction_session_timeout = '10s';
SET client_connection_check_interval = '2s';
SET tcp_keepalives_idle = 10;
SET tcp_keepalives_interval = 5;
SET tcp_keepalives_count = 3;
SET jit = off;
SET enable_seqscan = off;
SET enable_hashjoin = off;
SET enable_mergejoin = off;
SET enable_bitmapscan = off;
SET enable_sort = off;
SET enable_incremental_sort = off;
SET plan_cache_mode = force_generic_plan;
SET default_transaction_isolation = 'read committed';
SET meshgauge.bounds_by = 'told';
SELECT set_config('synchronous_commit', 'on', false)
  WHERE current_setting('synchronous_commit') IN ('off', 'local', 'remote_write');
)sql";

// A plan is made for the size that the tables have then, and PostgreSQL notices a change only after about a minute.
constexpr auto kPlansLast = std::chrono::seconds(3);
constexpr auto kSessionTime = std::chrono::seconds(4);

std::string one_line(std::string_view text) {
  std::string line;
  for (const char c : text) {
    if (c == '\n' || c == '\t') {
      if (!line.empty() && line.back() != ' ') line += ' ';
    } else {
      line += c;
    }
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

bool starts(const std::string& state, std::string_view with) { return state.starts_with(with); }

// 08: the connection; 25006: this server has become a standby; 57P: it is shutting down or starting; 53300: it has no
// connection left; 40: a deadlock, or another transaction was first; 55P03: a lock took too long; 0A000: a plan that a
// migration made invalid; 26000: a statement that the server does not know.
bool needs_another_connection(const std::string& state) {
  return starts(state, "08") || starts(state, "57P") || state == "25006" || state == "53300" || state == "0A000" ||
         state == "26000" || state == "25P03" || state == "25P02";
}
bool may_pass(const std::string& state) {
  return needs_another_connection(state) || starts(state, "40") || state == "55P03" || state == "57014" ||
         state == "55006" || starts(state, "58");
}

std::string field(const PGresult* result, int code) {
  const char* text = PQresultErrorField(result, code);
  return text == nullptr ? "" : text;
}

PgFailure failure_of(const PGresult* result) {
  const std::string state = field(result, PG_DIAG_SQLSTATE);
  return {state, one_line(field(result, PG_DIAG_MESSAGE_PRIMARY)), needs_another_connection(state), may_pass(state)};
}

// The statement timeout or an operator ended a commit's wait for a standby: it is committed here, but a failover may
// lose it. The function's name identifies the notice, because messages are translated.
bool is_about_replication(const PGresult* notice) {
  return field(notice, PG_DIAG_SOURCE_FUNCTION) == "SyncRepWaitForLSN";
}

int milliseconds_until(SteadyTime deadline) {
  if (deadline == SteadyTime::max()) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now()).count();
  return static_cast<int>(std::clamp<std::int64_t>(left, 0, 3'600'000));
}

}  // namespace

void PgValues::add(unsigned type, std::string bytes) {
  types_.push_back(type);
  values_.emplace_back(std::move(bytes));
}

void PgValues::add(std::string_view text) { add(kBytea, std::string(text)); }
void PgValues::add(std::span<const std::byte> bytes) {
  add(kBytea, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}
void PgValues::add(double real) { add(kFloat8, bytes_of(real)); }
void PgValues::add(bool flag) { add(kBool, std::string(1, flag ? '\1' : '\0')); }
void PgValues::add(std::int64_t number) { add(kInt8, bytes_of(number)); }
void PgValues::add(const std::vector<std::string>& texts) { add(kByteaArray, array_of(kBytea, texts)); }
void PgValues::add(const std::vector<std::optional<std::string>>& texts) { add(kByteaArray, array_of(kBytea, texts)); }
void PgValues::add(const std::vector<std::int64_t>& numbers) { add(kInt8Array, array_of(kInt8, numbers)); }
void PgValues::add(const std::vector<std::optional<std::int64_t>>& numbers) {
  add(kInt8Array, array_of(kInt8, numbers));
}
void PgValues::add(const std::vector<std::optional<double>>& reals) { add(kFloat8Array, array_of(kFloat8, reals)); }

std::vector<const char*> PgValues::pointers() const {
  std::vector<const char*> pointers;
  for (const auto& value : values_) pointers.push_back(value ? value->data() : nullptr);
  return pointers;
}

std::vector<int> PgValues::lengths() const {
  std::vector<int> lengths;
  for (const auto& value : values_) lengths.push_back(value ? static_cast<int>(value->size()) : 0);
  return lengths;
}

void PgRows::Cleared::operator()(pg_result* result) const { PQclear(result); }

int PgRows::size() const { return PQntuples(result_.get()); }

std::uint64_t PgRows::changed() const {
  const char* number = PQcmdTuples(result_.get());
  return *number == '\0' ? 0 : std::stoull(number);
}

bool PgRows::is_null(int column) const { return PQgetisnull(result_.get(), row_, column) != 0; }

std::string_view PgRows::bytes(int column) const {
  return {PQgetvalue(result_.get(), row_, column), static_cast<std::size_t>(PQgetlength(result_.get(), row_, column))};
}

std::int64_t PgRows::number(int column) const {
  const std::uint64_t raw = is_null(column) ? 0 : read_number(bytes(column));
  switch (PQftype(result_.get(), column)) {
    case kInt2:
      return static_cast<std::int16_t>(raw);
    case kInt4:
      return static_cast<std::int32_t>(raw);
    default:
      assert(PQftype(result_.get(), column) == kInt8 || PQftype(result_.get(), column) == kBool);
      return static_cast<std::int64_t>(raw);
  }
}

double PgRows::real(int column) const {
  assert(PQftype(result_.get(), column) == kFloat8);
  return std::bit_cast<double>(read_number(bytes(column)));
}

std::string PgRows::text(int column) const { return std::string(bytes(column)); }

std::optional<TimePoint> PgRows::time_if_any(int column) const {
  if (is_null(column)) return std::nullopt;
  return time(column);
}

Error to_error(const PgFailure& failure) {
  const std::string what = "the database ";
  if (failure.state == "53100") return {ErrorCode::storage_full, what + "has no room: " + failure.message, "", ""};
  if (failure.state.empty() || failure.connection_lost || failure.may_pass || starts(failure.state, "53") ||
      starts(failure.state, "28") || starts(failure.state, "3D") || starts(failure.state, "42501")) {
    return {ErrorCode::storage_unavailable, what + "cannot be used: " + failure.message, "", ""};
  }
  return {ErrorCode::internal, what + "failed: " + failure.message + " (" + failure.state + ")", "", ""};
}

void PgConnection::Closed::operator()(pg_conn* connection) const { PQfinish(connection); }

std::unique_ptr<PgConnection> PgConnection::open(const std::string& database) {
  std::vector<const char*> names, values;
  for (const auto& [name, value] : kDefaults) {
    names.push_back(name);
    values.push_back(value);
  }
  for (const auto& [name, value] : {std::pair("dbname", database.c_str()), {"target_session_attrs", "read-write"}}) {
    names.push_back(name);
    values.push_back(value);
  }
  names.push_back(nullptr);
  values.push_back(nullptr);
  std::unique_ptr<pg_conn, Closed> raw(PQconnectdbParams(names.data(), values.data(), 1));
  if (!raw) throw PgFailure{"53200", "no memory for a connection", true, false};
  if (PQstatus(raw.get()) != CONNECTION_OK) throw PgFailure{"", one_line(PQerrorMessage(raw.get())), true, true};
  std::unique_ptr<PgConnection> connection(new PgConnection(raw.release()));
  connection->set_deadline(std::chrono::steady_clock::now() + kSessionTime);
  connection->execute(kSession);
  connection->set_deadline(SteadyTime::max());
  return connection;
}

PgConnection::PgConnection(pg_conn* connection) : connection_(connection) {
  PQsetnonblocking(connection, 1);
  PQsetNoticeReceiver(
      connection,
      [](void* self, const PGresult* notice) {
        if (is_about_replication(notice)) static_cast<PgConnection*>(self)->unreplicated_ = true;
      },
      this);
}

bool PgConnection::usable() const { return !lost_ && PQstatus(connection_.get()) == CONNECTION_OK; }
bool PgConnection::in_transaction() const { return PQtransactionStatus(connection_.get()) != PQTRANS_IDLE; }
int PgConnection::socket() const { return PQsocket(connection_.get()); }

void PgConnection::lost(const std::string& why) {
  lost_ = true;
  throw PgFailure{"", why, true, true};
}

void PgConnection::wait(short events) {
  pollfd polled{socket(), events, 0};
  int ready = 0;
  do {
    ready = ::poll(&polled, 1, milliseconds_until(deadline_));
  } while (ready < 0 && errno == EINTR);
  if (ready <= 0) lost("it did not answer in time");
}

PgRows PgConnection::finish(bool sent) {
  if (!sent) lost(one_line(PQerrorMessage(connection_.get())));
  for (int left = 1; (left = PQflush(connection_.get())) != 0;) {
    if (left < 0) lost(one_line(PQerrorMessage(connection_.get())));
    wait(POLLIN | POLLOUT);
    if (PQconsumeInput(connection_.get()) == 0) lost(one_line(PQerrorMessage(connection_.get())));
  }
  PgRows rows(nullptr);
  std::optional<PgFailure> failure;
  while (true) {
    while (PQisBusy(connection_.get()) != 0) {
      wait(POLLIN);
      if (PQconsumeInput(connection_.get()) == 0) lost(one_line(PQerrorMessage(connection_.get())));
    }
    PGresult* result = PQgetResult(connection_.get());
    if (result == nullptr) break;
    rows = PgRows(result);
    const ExecStatusType status = PQresultStatus(result);
    if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK && !failure) failure = failure_of(result);
  }
  if (PQstatus(connection_.get()) != CONNECTION_OK) lost(failure ? failure->message : "the connection was closed");
  if (failure) {
    lost_ = failure->connection_lost;
    throw PgFailure(*failure);
  }
  if (std::exchange(unreplicated_, false)) {
    throw PgFailure{"", "no other server has confirmed what was stored", false, true};
  }
  return rows;
}

const std::string& PgConnection::prepared(const char* sql, const PgValues& values) {
  const auto found = names_.find(sql);
  if (found != names_.end()) return found->second;
  // A name of its own for each try: the server may know a statement whose preparation failed here.
  const std::string name = "s" + std::to_string(prepared_++);
  finish(PQsendPrepare(connection_.get(), name.c_str(), sql, values.size(), values.types()) != 0);
  return names_.emplace(sql, name).first->second;
}

PgRows PgConnection::query(const char* sql, const PgValues& values) {
  if (std::chrono::steady_clock::now() >= plans_until_) {
    plans_until_ = std::chrono::steady_clock::now() + kPlansLast;
    execute("DISCARD PLANS");
  }
  const std::string& name = prepared(sql, values);
  const std::vector<int> binary(static_cast<std::size_t>(values.size()), 1);
  return finish(PQsendQueryPrepared(connection_.get(), name.c_str(), values.size(), values.pointers().data(),
                                    values.lengths().data(), binary.data(), 1) != 0);
}

PgRows PgConnection::execute(const std::string& sql) {
  return finish(PQsendQuery(connection_.get(), sql.c_str()) != 0);
}

// Reads what the server sent before it closed the connection.
void PgConnection::read_all() {
  pollfd polled{socket(), POLLIN, 0};
  while (::poll(&polled, 1, 0) > 0) {
    if (PQconsumeInput(connection_.get()) == 0) lost(one_line(PQerrorMessage(connection_.get())));
  }
}

std::vector<PgConnection::Notification> PgConnection::notifications() {
  read_all();
  std::vector<Notification> all;
  while (PGnotify* notify = PQnotifies(connection_.get())) {
    all.push_back({notify->relname, notify->extra});
    PQfreemem(notify);
  }
  return all;
}

PgTransaction::~PgTransaction() {
  if (!connection_.usable() || !connection_.in_transaction()) return;
  try {
    connection_.execute("ROLLBACK");
  } catch (const PgFailure&) {  // give_back() sees that the connection is still in a transaction
  }
}

void PgTransaction::commit() { connection_.execute("COMMIT"); }

}  // namespace meshgauge::server::store
