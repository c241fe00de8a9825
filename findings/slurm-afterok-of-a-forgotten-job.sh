#!/usr/bin/env bash
# Slurm 22.05.8 (Debian 12), a controller and one node on 127.0.0.1 without accounting.
#
# A bake fails (exit 3). Once the controller has forgotten it (MinJobAge: 300 s by default, 2 s here), the merge is
# submitted with --dependency=afterok:BAKE; another with afterok on a job number that never was.
# Guess: both are refused, or wait for ever (DependencyNeverSatisfied), as the merge does that is submitted at once.
# Seen:  both are taken and run at once, and end COMPLETED: a number that the controller doesn't know counts as done
#        well. A merge that comes five minutes late runs over the remains of a bake that failed.
. "$(dirname "$0")/lib.sh"
debian_with slurmctld 22.05.8-4+deb12u3 slurmd 22.05.8-4+deb12u3 slurm-client 22.05.8-4+deb12u3 munge 0.5.15-2+deb12u1
cd "$work"
chmod 755 "$work"
mkdir state spool run
user=$(id -un)
cat > slurm.conf <<CONF
ClusterName=sandbox
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=17817
SlurmdPort=17818
AuthType=auth/munge
AuthInfo=socket=$work/run/munge
SlurmUser=$user
SlurmdUser=$user
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/run/slurmctld.pid
SlurmdPidFile=$work/run/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
ReturnToService=2
MinJobAge=2
SchedulerParameters=sched_min_interval=0,bf_interval=1
NodeName=localhost NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
CONF
export SLURM_CONF="$work/slurm.conf"
stop() {
    for name in slurmd slurmctld munged; do
        [ ! -s "run/$name.pid" ] || kill "$(cat "run/$name.pid")" || true
    done
    sleep 1
    rm -rf "$work"
}
trap stop EXIT
(umask 077 && head --bytes 1024 /dev/urandom > key)
munged --force --key-file="$work/key" --socket="$work/run/munge" --pid-file="$work/run/munged.pid" --log-file="$work/munged.log" --seed-file="$work/seed"
slurmctld -c
slurmd -c -N localhost
for _ in $(seq 30); do [ "$(sinfo --noheader --format %T)" = idle ] && break; sleep 1; done

state_of() { scontrol show job "$1" 2>/dev/null | sed -n 's/.*JobState=\([A-Z]*\) Reason=\([A-Za-z]*\).*/\1 \2/p'; }
submit() { sbatch --parsable --output=/dev/null "$@"; }

bake=$(submit --wrap 'exit 3')
early=$(submit --dependency="afterok:$bake" --wrap true)
for _ in $(seq 30); do [ "$(state_of "$bake")" ] || break; sleep 2; done
late=$(submit --dependency="afterok:$bake" --wrap true)
never=$(submit --dependency=afterok:999999 --wrap true)
early_state=$(state_of "$early")
for _ in $(seq 30); do
    late_state=$(state_of "$late") never_state=$(state_of "$never")
    case "$late_state,$never_state" in COMPLETED*,COMPLETED*) break ;; esac
    sleep 0.5
done
scancel "$early"

echo "question: state of merges with afterok on the failed job: submitted at once; after it was forgotten; on a number that never was"
echo "guess:    never satisfied, three times (or the last two refused)"
echo "seen:     $early_state; $late_state; $never_state"
[ "$early_state; $late_state; $never_state" = "PENDING DependencyNeverSatisfied; COMPLETED None; COMPLETED None" ] || { echo CHANGED; exit 1; }
