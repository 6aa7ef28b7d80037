#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs the examples of man/iblbake-cluster.7 as they are printed there: GNU
# parallel, make -j, and job arrays of a Slurm that this script starts on this
# machine, as root, with all its files in a temporary directory. A task is killed
# and queued again. BUILD names the build.
set -u
. tests/lib.sh
need node
use iblbake
real=$work/bin/iblbake
cd "$work" || exit 1

# The literal block after the line of the manual that names it.
example() { # NAME
    awk -v name=".Pa $1" '$0 == name || index($0, name " ") == 1 { on = 1 }
        on && /^\.Ed/ { exit }
        literal
        on && /^\.Bd -literal/ { literal = 1 }' \
        "$top/man/iblbake-cluster.7" | sed "s/\\\\(aq/'/g; s/\\\\e/\\\\/g" >"$1"
    [ -s "$1" ] || echo "wanted $1 in the manual, found no text"
}
# A directory with 8 sets of 8 probes, 40 maps and the manual's files.
begin() { # DIRECTORY FILE...
    rm -rf "${work:?}/$1"
    mkdir "$work/$1" && cd "$work/$1" || return
    ln -s ../sets ../captures ../env ../maps.txt .
    for file in "${@:2}"; do example "$file"; done
}
# Like iblbake, with options that take less time.
mkdir quick captures env sets
cat >quick/iblbake <<END
#!/bin/sh
case "\$1" in
probes) exec "$real" "\$@" ;;
*) exec "$real" --size 8 --lut-size 16 --lobe-table-size 8 \\
    --irradiance-size 4 "\$@" ;;
esac
END
chmod +x quick/iblbake
PATH=$work/quick:$PATH
for i in 0 1 2 3 4 5 6 7; do
    mkenv exr $((32 + 8 * i)) $((16 + 4 * i)) BGR >captures/$i.exr
done
for ((i = 0; i < 40; i++)); do
    cp captures/$((i % 8)).exr env/map$i.exr
    echo env/map$i.exr
done >maps.txt
# They are older than the grace of --incremental.
touch -d '1 hour ago' env/*
iblbake -q --from maps.txt -o lit || exit 1
node -e "for (let k = 0; k < 8; k++)
    require('fs').writeFileSync('sets/set' + k + '.json', JSON.stringify({
        version: 1,
        defaults: {size: 8, levels: 2, irradiance: 4, lut_size: 16},
        global: {capture: {equirect: '../captures/' + k + '.exr'}},
        probes: Array.from({length: 8}, (_, i) => ({name: 'p' + i,
            position: [i, 0, 0],
            capture: {equirect: '../captures/' + i + '.exr'},
            influence: {sphere: {centre: [i, 0, 0], radius: 1}}}))}))"
iblbake probes -q sets/*.json -o whole || exit 1

test_parallel() {
    begin parallel shards.sh
    works sh -e shards.sh
    diff -r out ../whole
    diff -r lit ../lit
}
test_make() {
    begin make Makefile
    works make -s -j4
    diff -r out ../whole
    diff -r -x '*.d' lit ../lit
    make -q || is 0 $? 'status of make -q, where nothing changed'
    rm lit/map7*
    make -s && diff -r -x '*.d' lit ../lit
}

test_measure() {
    begin measure measure.sh
    cp env/map7.exr 8k.hdr
    sh -e measure.sh >printed 2>&1 || is 0 $? "$(cat printed): status"
    count 2 '^[0-9.]*+[0-9.]* s [0-9]* KiB$' printed
    diff -r out ../whole/set1
}

# ---- Slurm ---------------------------------------------------------------------
export SLURM_CONF=$work/slurm/slurm.conf
daemons=
# Ends everything that was started: jobs, then their daemons, then what is left
# of them, which is known by its environment.
stop() {
    local pid
    [ -e "$SLURM_CONF" ] || return
    timeout 10 scancel --full --user=root 2>/dev/null
    # shellcheck disable=SC2086
    kill $daemons 2>/dev/null
    wait
    for pid in /proc/[0-9]*; do
        grep -qsz "^SLURM_CONF=$SLURM_CONF\$" "$pid/environ" &&
            [ "${pid#/proc/}" != $$ ] && kill -9 "${pid#/proc/}" 2>/dev/null
    done
}
trap 'cd "$work"; stop; rm -rf "$work"' EXIT
trap 'exit 1' INT TERM HUP
missing() { # why there is no Slurm here
    local program
    {
        [ "$(id -u)" = 0 ] ||
            echo 'Slurm with its files in a directory needs root'
        for program in munged slurmctld slurmd sbatch; do
            command -v $program >/dev/null || echo "$program is not installed"
        done
        grep -q ' /sys/fs/cgroup' /proc/mounts ||
            echo 'slurmd needs /sys/fs/cgroup, where nothing is mounted'
    } | head -n 1
}
is_up() { sinfo -h -o %t 2>/dev/null | grep -qx idle; }
in_background() { # NAME COMMAND...
    "${@:2}" >"slurm/$1.out" 2>&1 &
    daemons="$daemons $!"
}
start() {
    local slurm=$work/slurm ports node
    node=$(hostname -s)
    mkdir -p slurm/state slurm/spool
    (umask 077; head -c 1024 /dev/urandom >slurm/key)
    ports=$(node -e "const net = require('net'), all = [0, 0].map(() =>
        net.createServer().listen(0, '127.0.0.1', () => {
            if (all.every(s => s.address())) {
                console.log(all.map(s => s.address().port).join(' '));
                all.forEach(s => s.close());
            }
        }))")
    # Credentials of 5 s: a task that is queued again waits for the end of its
    # old one. More CPUs than there may be, so that all tasks run at once.
    cat >slurm/slurm.conf <<END
ClusterName=check
SlurmctldHost=$node(127.0.0.1)
SlurmctldPort=${ports% *}
SlurmdPort=${ports#* }
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$slurm/socket,cred_expire=5
CredType=cred/munge
StateSaveLocation=$slurm/state
SlurmdSpoolDir=$slurm/spool
SlurmctldPidFile=$slurm/slurmctld.pid
SlurmdPidFile=$slurm/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
ReturnToService=2
MailProg=/bin/true
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=1,batch_sched_delay=0
NodeName=$node NodeAddr=127.0.0.1 CPUs=16 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=5 State=UP
END
    in_background munged munged --foreground --force --key-file=$slurm/key \
        --socket=$slurm/socket --pid-file=$slurm/munged.pid \
        --seed-file=$slurm/seed --log-file=$slurm/munged.log --num-threads=2
    within test -S slurm/socket || return
    in_background slurmctld slurmctld -D -i
    in_background slurmd slurmd -D
    within is_up
}
is_idle() { [ -z "$(squeue -h 2>&1)" ]; }
# Waits until no job is left, and prints what the jobs have said.
finish() {
    within is_idle || squeue
    cat ./*.log
}

# Task 3 of 4 dies of SIGKILL before KILL_AT files have got their names.
preload
mkdir deadly
cat >deadly/iblbake <<END
#!/bin/sh
case "\$*" in
*'--shard 3/4 '*) echo "\$SLURM_RESTART_COUNT" >>tries
    [ "\$SLURM_RESTART_COUNT" ] ||
        export LD_PRELOAD=$work/preload.so FAULT="rename -9 \$KILL_AT" ;;
esac
exec "$work/quick/iblbake" "\$@"
END
chmod +x deadly/iblbake

test_slurm_task_that_dies() {
    begin dies maps.sh probes.sh
    export PATH=$work/deadly:$PATH
    KILL_AT=8 sbatch maps.sh >submitted
    KILL_AT=2 sbatch probes.sh >>submitted || is 0 $? "sbatch: status"
    finish | grep -v -e Killed -e 'DUE TO JOB REQUEUE'
    sort tries | diff - <(printf '\n\n1\n1\n')
    diff -r out ../whole
    # Nothing is left to do, but to remove what the task has left.
    find lit -type f ! -name '.*.tmp' -printf '%p %i %T@\n' >was
    SLURM_ARRAY_TASK_ID=3 sh maps.sh
    find lit -type f -printf '%p %i %T@\n' | diff was -
    diff -r -x .iblbake lit ../lit
}
why=$(missing)
for name in $(sed -n 's/^\(test_[a-z_]*\)() {$/\1/p' \
    "$top/tests/check-cluster.sh"); do
    picked "$name" || continue
    case $name in
    test_parallel) lack=$(have parallel) ;;
    test_measure) lack=$([ -x /usr/bin/time ] || echo 'skipped: no /usr/bin/time') ;;
    test_slurm_*) lack=${why:+skipped: $why} ;;
    *) lack= ;;
    esac
    if [ -n "$lack" ]; then
        verdict "$name" "$lack"
        continue
    fi
    if [[ $name == test_slurm_* ]] && [ ! -e "$SLURM_CONF" ] && ! start; then
        verdict slurm "does not start: $(tail -n 5 slurm/*.out slurm/*.log)"
        break
    fi
    verdict "$name" "$($name 2>&1)"
done
end
