// SPDX-License-Identifier: MIT
/** Options of the command line in camelCase, `irradianceSize: 32` for
 * `--irradiance-size 32`: see `npx iblbake --help`. Flags are true; lists are
 * arrays or have commas. */
export interface Options {
    /** Name of the input: its ending says nothing, its stem names the outputs. */
    name?: string;
    /** Is told the share of the bake that is done, or of a stage before or after it. */
    onProgress?: (share: number) => void;
    /** Threads of the run, in node: 1 unless this says more, up to 64. Pages have one. */
    threads?: number;
    /** Ends the run at once, which then rejects with the signal's reason. */
    signal?: AbortSignal;
    [option: string]: unknown;
}
export type Bytes = Uint8Array | ArrayBuffer | Blob;
export type Files = Record<string, Uint8Array>;

/** What functions reject with: messages, exit status, and what was printed, as the JSON
 * of verify with an error above `maxError`. */
export interface IblbakeError extends Error { name: 'IblbakeError'; status: number; text: string }

/** Bakes an environment. report: the sidecar; log: warnings, with `verbose`
 * what was done; text: what was asked to be printed, as by `explain`. */
export function bake(environment: Bytes, options?: Options):
    Promise<{ files: Files; report: any; log: string; text: string }>;
/** Measures the errors of a bake of the environment. */
export function verify(environment: Bytes, set: Record<string, Bytes>, options?: Options):
    Promise<{ report: any; log: string }>;
/** Says what a texture or an environment is. */
export function info(file: Bytes, options?: Options): Promise<{ report: any; log: string }>;
/** Writes a texture in another container, format or layout: what the ending of
 * the name `to` says. */
export function convert(texture: Bytes, options: Options & { to: string }):
    Promise<{ files: Files; log: string }>;
/** Runs any command line on files in memory, and gives those that it made. */
export function run(args: string[], files?: Files,
    options?: Pick<Options, 'onProgress' | 'signal'>):
    Promise<{ status: number; files: Files; stdout: string; stderr: string }>;
