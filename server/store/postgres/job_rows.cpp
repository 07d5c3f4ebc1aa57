#include "server/store/postgres/job_rows.h"

#include "server/store/policy.h"
#include "server/store/rows.h"

namespace meshgauge::server::store {
namespace {

std::int64_t ms(TimePoint time) { return time.time_since_epoch().count(); }

std::optional<std::int64_t> ms(const std::optional<TimePoint>& time) {
  if (!time) return std::nullopt;
  return ms(*time);
}

// One member of all rows, as the array of a column.
template <class Of>
auto column(std::span<const JobRow> rows, Of of) {
  std::vector<std::decay_t<decltype(of(rows.front()))>> values;
  values.reserve(rows.size());
  for (const JobRow& row : rows) values.push_back(of(row));
  return values;
}

template <class Member>
auto column(std::span<const JobRow> rows, Member NewJob::*member) {
  return column(rows, [member](const JobRow& row) { return row.job.*member; });
}
template <class Member>
auto column(std::span<const JobRow> rows, Member Job::*member) {
  return column(rows, [member](const JobRow& row) { return row.job.*member; });
}
template <class Member>
auto column(std::span<const JobRow> rows, Member JobRow::*member) {
  return column(rows, [member](const JobRow& row) { return row.*member; });
}
template <class Time, class Class>
auto times(std::span<const JobRow> rows, Time Class::*member) {
  return column(rows, [member](const JobRow& row) { return ms(row.job.*member); });
}
auto reals(std::span<const JobRow> rows, double Progress::*member) {
  return column(rows, [member](const JobRow& row) {
    return row.job.progress ? std::optional((*row.job.progress).*member) : std::nullopt;
  });
}

}  // namespace

std::uint64_t insert_rows(PgConnection& connection, std::span<const JobRow> rows) {
  const auto number = [](auto of) { return [of](const JobRow& row) { return static_cast<std::int64_t>(of(row)); }; };
  const PgValues values(
      column(rows, [](const JobRow& row) { return row.job.key.owner; }),
      column(rows, [](const JobRow& row) { return row.job.key.id; }),
      column(rows, number([](const JobRow& row) { return row.job.state; })), column(rows, &NewJob::mesh_a),
      column(rows, &NewJob::mesh_b), column(rows, &NewJob::hints), column(rows, &NewJob::options),
      column(rows, number([](const JobRow& row) { return row.job.cost; })),
      column(rows, [](const JobRow& row) { return rank_of(row.job); }),
      column(rows, [](const JobRow& row) { return none_if_empty(row.job.idempotency_key); }),
      column(rows, &NewJob::fingerprint), column(rows, &NewJob::trace), times(rows, &NewJob::created),
      times(rows, &NewJob::expires_if_never_run), column(rows, &NewJob::batch), times(rows, &NewJob::deadline),
      column(rows, number([](const JobRow& row) { return row.job.tries; })),
      column(rows, number([](const JobRow& row) { return row.job.cancel_requested; })), times(rows, &Job::started),
      times(rows, &Job::finished), times(rows, &Job::expires), reals(rows, &Progress::lower),
      reals(rows, &Progress::upper),
      column(
          rows,
          [](const JobRow& row) { return row.job.progress ? std::optional(row.job.progress->stage) : std::nullopt; }),
      column(rows, &Job::document), column(rows, &Job::problem), column(rows, &Job::last_error),
      column(rows, &Job::verdict), column(rows, &JobRow::work),
      column(rows, [](const JobRow& row) { return row.job.progress ? row.job.progress->by : std::string(); }),
      column(rows, [](const JobRow& row) { return client_of(row.job); }));
  return connection
      .query(R"sql(
    INSERT INTO jobs (owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, idempotency_key, fingerprint, trace,
      created, expires_if_never_run, batch, deadline, tries, cancel_requested, started, finished, expires, lower, upper,
      stage, document, problem, last_error, verdict, work, bounds_by, client)
    SELECT owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, idempotency_key, fingerprint, trace,
      created, expires_if_never_run, batch, deadline, tries, cancel_requested <> 0, started, finished, expires, lower,
      upper, stage, document, problem, last_error, verdict, work, bounds_by, client
    FROM unnest($1::bytea[], $2::bytea[], $3::int8[], $4::bytea[], $5::bytea[], $6::bytea[], $7::bytea[], $8::int8[],
        $9::int8[], $10::bytea[], $11::bytea[], $12::bytea[], $13::int8[], $14::int8[], $15::bytea[], $16::int8[],
        $17::int8[], $18::int8[], $19::int8[], $20::int8[], $21::int8[], $22::float8[], $23::float8[], $24::bytea[],
        $25::bytea[], $26::bytea[], $27::bytea[], $28::bytea[], $29::bytea[], $30::bytea[], $31::bytea[])
      WITH ORDINALITY AS given (owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, idempotency_key,
        fingerprint, trace, created, expires_if_never_run, batch, deadline, tries, cancel_requested, started, finished,
        expires, lower, upper, stage, document, problem, last_error, verdict, work, bounds_by, client, place)
    ORDER BY place
    ON CONFLICT DO NOTHING)sql",
             values)
      .changed();
}

}  // namespace meshgauge::server::store
