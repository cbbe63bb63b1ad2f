"""Shared by the tests of parallel jobs: results of all jobs in the order of the jobs, not as they are done."""

from contextlib import closing

from rollbench.compare.reference.parallel import run_jobs


def run(jobs, backend="joblib", scheduler=None, workers=None, step=lambda _: None):
    results = [None] * len(jobs)
    with closing(run_jobs(jobs, backend, scheduler, workers)) as finished:
        for done, (number, result) in enumerate(finished, start=1):
            results[number] = result
            step(f"job {number + 1} done, {done} of {len(jobs)}")
    return results
